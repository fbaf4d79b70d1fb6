#!/usr/bin/env bash
# SPDX-License-Identifier: Apache-2.0
#
# install-cuda.sh [FOLDER]: installs the CUDA compiler (nvcc, runtime, CCCL, nvdisasm) from PyPI to FOLDER, by default
# /usr/local/cuda, where the build finds it. No GPU and no driver are needed. Does nothing where FOLDER has nvcc.
set -euo pipefail

version=13.2
folder=${1:-/usr/local/cuda}
[ ! -x "$folder/bin/nvcc" ] || exit 0
if [ -e "$folder" ]; then
  echo "$folder exists, but has no nvcc: name another folder." >&2
  exit 2
fi
if ! python3 -m pip --version >/dev/null 2>&1; then
  echo "pip is missing: apt-get install python3-pip" >&2
  exit 2
fi
packages=()
for name in cuda-nvcc cuda-crt nvvm cuda-runtime cuda-cccl cuda-nvdisasm; do packages+=("nvidia-$name==$version.*"); done
mkdir -p "$(dirname "$folder")"
downloaded=$(mktemp -d "$(dirname "$folder")/cuda-XXXXXX")
trap 'rm -rf "$downloaded"' EXIT
python3 -m pip install --quiet --disable-pip-version-check --root-user-action ignore --no-deps --target "$downloaded" "${packages[@]}"
mv "$downloaded/nvidia/cu${version%.*}" "$folder"
ln -s lib "$folder/lib64"
chmod 755 "$folder"
"$folder/bin/nvcc" --version | sed -n '$p'
