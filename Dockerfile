# The two commands of the README in a container:
#
#     docker build -t underbrush .
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD/out:/underbrush/out" underbrush         # reproduce --quick
#     docker run --rm --user "$(id -u):$(id -g)" -v "$PWD:/underbrush" underbrush generate scenes/leaf.toml --reaches 3 \
#         --out my-set
#     docker build --target test -t underbrush-test .                       # cargo test
#
# `--user` lets the program write to a folder of the host. The images are named by digest, because a tag can be moved to
# another image. The digest of a newer one:
#
#     docker buildx imagetools inspect rust:1.95-bookworm --format '{{.Manifest.Digest}}'
ARG RUST=rust:1.95-bookworm@sha256:6258907abe69656e41cd992e0b705cdcfabcbbe3db374f92ed2d47121282d4a1
ARG DEBIAN=debian:bookworm-slim@sha256:3783cc01769c7b2b1b83a5c5ad96c815348e28ed7da68e2e3687004faa906251
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
