// Functions of a math library whose last digits differ from those of any real one. A program that is started with this
// library before all others (LD_PRELOAD) computes other values wherever it calls one of them.
#define _GNU_SOURCE
#include <dlfcn.h>
#include <math.h>

#define REAL(type, name, parameters) \
    static type(*real) parameters;   \
    if (!real) real = dlsym(RTLD_NEXT, #name);

// Three units in the last place more, at every call.
static double other(double value) {
    for (int i = 0; i < 3; i++) value = nextafter(value, INFINITY);
    return value;
}

#define ONE(name)           \
    double name(double x) { \
        REAL(double, name, (double)) return other(real(x)); \
    }
#define TWO(name)                     \
    double name(double x, double y) { \
        REAL(double, name, (double, double)) return other(real(x, y)); \
    }

ONE(sin) ONE(cos) ONE(tan) ONE(asin) ONE(acos) ONE(atan) ONE(sinh) ONE(cosh) ONE(tanh) ONE(exp) ONE(exp2) ONE(expm1)
ONE(log) ONE(log2) ONE(log10) ONE(log1p) ONE(cbrt) TWO(pow) TWO(hypot) TWO(atan2)

void sincos(double x, double *sine, double *cosine) {
    REAL(void, sincos, (double, double *, double *))
    real(x, sine, cosine);
    *sine = other(*sine);
    *cosine = other(*cosine);
}
