#!/usr/bin/env bash
# Configures and builds everything into build/release.
set -euo pipefail
cd "$(dirname "$0")/.."
launcher=()
if command -v ccache >/dev/null; then launcher=(-DCMAKE_CXX_COMPILER_LAUNCHER=ccache -DCMAKE_C_COMPILER_LAUNCHER=ccache); fi
cmake --preset release "${launcher[@]}" >build-configure.log || { cat build-configure.log; exit 1; }
rm -f build-configure.log
cmake --build --preset release -- -k 1
