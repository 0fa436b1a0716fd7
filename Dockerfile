# The two commands of the README in a container:
#
#     docker build -t underbrush .
#     docker run --rm -v "$PWD/out:/underbrush/out" underbrush               # reproduce --quick
#     docker run --rm -v "$PWD:/underbrush" underbrush generate scenes/leaf.toml --reaches 3 --out my-set
#     docker build --target test -t underbrush-test .                       # cargo test
FROM rust:1.95-bookworm AS build
WORKDIR /src
COPY . .
RUN cargo build --release --locked

FROM build AS test
RUN cargo test --release --workspace --locked

FROM debian:bookworm-slim
COPY --from=build /src/target/release/underbrush /usr/local/bin/underbrush
COPY --from=build /src/scenes /underbrush/scenes
COPY --from=build /src/suites /underbrush/suites
WORKDIR /underbrush
ENTRYPOINT ["underbrush"]
CMD ["reproduce", "--quick", "--out", "out/reproduce"]
