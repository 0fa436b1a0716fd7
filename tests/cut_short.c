/* Cuts one call of read or write short: it reads or writes only the first half of the bytes and returns their number,
 * as the kernel does when a disk is nearly full or a signal arrives. Load it with LD_PRELOAD; tests/faults.py compiles
 * it.
 *
 *     CUT_CALL=read|write   CUT_NUMBER=n, counted from 1 over all threads
 *     CUT_THEN=nothing|kill|NUMBER: what happens next; NUMBER is the errno with which later calls on this file fail
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <signal.h>
#include <stdatomic.h>
#include <stdlib.h>
#include <string.h>
#include <unistd.h>

static atomic_long calls;
static atomic_int file_that_fails = -1;

typedef ssize_t transfer(int, void *, size_t);

static ssize_t call(const char *name, int file, void *bytes, size_t count) {
    transfer *real = (transfer *)dlsym(RTLD_NEXT, name);
    const char *cut = getenv("CUT_CALL"), *number = getenv("CUT_NUMBER"), *then = getenv("CUT_THEN");
    if (!cut || !number || !then || strcmp(cut, name) != 0)
        return real(file, bytes, count);
    if (file == file_that_fails) {
        errno = atoi(then);
        return -1;
    }
    if (++calls != atol(number) || count < 2)
        return real(file, bytes, count);
    ssize_t done = real(file, bytes, count / 2);
    if (strcmp(then, "kill") == 0)
        kill(getpid(), SIGKILL);
    if (strcmp(then, "nothing") != 0)
        file_that_fails = file;
    return done;
}

ssize_t read(int file, void *bytes, size_t count) { return call("read", file, bytes, count); }

ssize_t write(int file, const void *bytes, size_t count) { return call("write", file, (void *)bytes, count); }
