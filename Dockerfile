# The two commands of the README in a container:
#
#     docker build -t underbrush .
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD/out:/underbrush/out" underbrush         # reproduce --quick
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/underbrush" underbrush generate scenes/leaf.toml --reaches 3 \
#         --out my-set
#     docker build --target test -t underbrush-test .                       # cargo test
#
# `--user` lets the program write to a folder of the host. A tag can be moved to another image. To build from the very
# same ones again, name them by digest:
#
#     docker buildx imagetools inspect rust:1.95-bookworm --format '{{.Manifest.Digest}}'
#     docker build --build-arg RUST=rust@sha256:… --build-arg DEBIAN=debian@sha256:… -t underbrush .
ARG RUST=rust:1.95-bookworm
ARG DEBIAN=debian:bookworm-slim
FROM ${RUST} AS build
WORKDIR /src
COPY . .
RUN cargo build --release --locked

FROM build AS test
RUN cargo test --release --workspace --locked

FROM ${DEBIAN}
RUN useradd --create-home underbrush && install -d -o underbrush -g underbrush /underbrush/out
COPY --from=build /src/target/release/underbrush /usr/local/bin/underbrush
COPY --from=build /src/scenes /underbrush/scenes
COPY --from=build /src/suites /underbrush/suites
WORKDIR /underbrush
USER underbrush
ENTRYPOINT ["underbrush"]
CMD ["reproduce", "--quick", "--out", "out/reproduce"]
