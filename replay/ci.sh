#!/usr/bin/env bash
# Checks the page: its types, that the checked-in build is the build of its sources, and its tests in Chromium, which also read the
# report of `reproduce --quick`.
# With --without-browser it leaves out the tests in Chromium, for which the program must have been built
# (cargo test --release --workspace). Needs Node 20.19 or later, and installs whatever else is missing: Chromium with
# apt-get, and packages with npm at the versions of package-lock.json.
set -euo pipefail
cd "$(dirname "$0")/page"

install() {
  local sudo=
  [ "$(id -u)" = 0 ] || sudo=sudo
  $sudo apt-get update -q
  DEBIAN_FRONTEND=noninteractive $sudo apt-get install -q -y --no-install-recommends "$@"
}
command -v node > /dev/null || install nodejs npm
node -e 'const [a, b] = process.versions.node.split(".").map(Number);
  if (a < 20 || (a === 20 && b < 19)) { console.error(`Node ${process.versions.node} is too old: install 20.19 or later`); process.exit(1); }'

npm ci --no-audit --no-fund
npm run check
built=$(mktemp -d)
trap 'rm -rf "$built"' EXIT
npm run build -- --outDir "$built" --emptyOutDir
cmp "$built/index.html" dist/index.html || {
  echo "replay/page/dist is not the build of replay/page/src: run \`npm run build\` in replay/page and commit it" >&2
  exit 1
}
[ "${1:-}" != --without-browser ] || exit 0

export CHROMIUM=${CHROMIUM:-/usr/bin/chromium}
[ -x "$CHROMIUM" ] || install chromium fonts-liberation
# One folder of recordings for all tests.
mkdir "$built/data"
REPLAY_DATA=$built/data npm test
