#!/usr/bin/env bash
# Everything that docs/gpu.md states of a GPU, in one run without network: tests, speed, memory,
# DLPack, getframes on CuPy, profile. The most important comes first; each part has its own limit.
#
#   benchmarks/gpu_all.sh OUT [WHEELS]    logs and JSON go to OUT; WHEELS is a folder of packages
#
# The Python in use must have CuPy, pytest and the packages of pyproject.toml, or WHEELS must.
set -u
out=$(mkdir -p "${1:?usage: gpu_all.sh OUT [WHEELS]}" && cd "$1" && pwd)
wheels=${2:-}
cd "$(dirname "$0")/.." || exit 2
site=$(mktemp -d)
trap 'rm -rf "$site"' EXIT
install=(python3 -m pip install -q --no-index --no-deps --no-compile --upgrade --target "$site")
[ -z "$wheels" ] || "${install[@]}" "$wheels"/*.whl || exit 2
export PYTHONPATH="$site"
"${install[@]}" --no-build-isolation . >"$out/install.log" 2>&1 || {
  echo "not installed (install.log); the source tree is used as it is"
  export PYTHONPATH="$site:$PWD:$PWD/cli"
}
part() { # name, seconds, command
  local name=$1 limit=$2 begun=$SECONDS
  shift 2
  timeout "$limit" "$@" >"$out/$name.log" 2>&1
  echo "== $name: exit $?, $((SECONDS - begun)) s"
  tail -n 30 "$out/$name.log"
}
part tests 150 python3 -m pytest -p no:benchmark -m gpu tests/model/gpu
[ -n "${SKIP:-}" ] || part speed 180 python3 benchmarks/gpu.py --json "$out/gpu.json"
if command -v ncu >/dev/null; then
  # The first kernel is of the first batch; the second shows the fields already in the cache.
  part profile 60 ncu --clock-control none --set full -k 'regex:pass_' -c 4 \
    python3 benchmarks/gpu.py --profile "ten effects"
fi
