#!/bin/sh
# Fetches the meshes and textures that the scenes name, out of Debian packages, into a cache folder: nothing of them is
# kept in this repository. May be run again; what is there already is not fetched anew.
#   --benchmark       also the objects of the benchmark of viewpoint planners (integration-tests/nbv_benchmark)
#   --calibration     also the chessboard images that the tests of `periplus calibrate` take: 96 MB to fetch
#   --stereo          also two real stereo pairs with true disparity (integration-tests/eyes_benchmark): 117 MB to fetch
#   PERIPLUS_ASSETS   the cache folder; default ~/.cache/periplus/assets
set -eu

assets=${PERIPLUS_ASSETS:-${XDG_CACHE_HOME:-$HOME/.cache}/periplus/assets}
mkdir -p "$assets"
temporary=$(mktemp -d)
trap 'rm -rf "$temporary"' EXIT

# package, then file in it, then name in the cache; a file "archive//member" lies in a tar archive of the package,
# "archive%%member" in a zip archive
list='
glmark2-data      usr/share/glmark2/models/bunny.obj                                        bunny.obj
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/triceratops.off        triceratops.off
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/refined_elephant.off   elephant.off
libmujoco-samples usr/share/mujoco/model/mug/mug.obj                                        mug.obj
libmujoco-samples usr/share/mujoco/model/mug/mug.png                                        mug.png
'
# What the benchmark of viewpoint planners explores beside these (integration-tests/nbv_benchmark): 120 MB to fetch.
if [ "${1:-}" = --benchmark ]; then list="$list
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/bear.off               bear.off
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/cow.off                cow.off
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/homer.off              homer.off
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/dino.off               dino.off
libcgal-demo      usr/share/doc/libcgal-dev/data.tar.gz//data/meshes/lion.off               lion.off
sweethome3d-furniture usr/share/sweethome3d/furniture/Scopia.sh3f%%scopia/dog/dog.obj       dog.obj
"
fi
# Stereo pairs of a chessboard, 9 x 6 corners; OpenCV has no pair 10.
if [ "${1:-}" = --calibration ]; then
  for pair in 01 02 03 04 05 06 07 08 09 11 12 13 14; do
    for eye in left right; do list="$list
opencv-doc        usr/share/doc/opencv-doc/examples/data/$eye$pair.jpg                      calibration/$eye$pair.jpg"
    done
  done
fi
# Real stereo pairs with their true disparity.
if [ "${1:-}" = --stereo ]; then list="$list
opencv-doc        usr/share/doc/opencv-doc/examples/data/aloeL.jpg                          stereo/aloeL.jpg
opencv-doc        usr/share/doc/opencv-doc/examples/data/aloeR.jpg                          stereo/aloeR.jpg
opencv-doc        usr/share/doc/opencv-doc/examples/data/aloeGT.png                         stereo/aloeGT.png
python3-skimage   usr/lib/python3/dist-packages/skimage/data/motorcycle_left.png            stereo/motorcycle_left.png
python3-skimage   usr/lib/python3/dist-packages/skimage/data/motorcycle_right.png           stereo/motorcycle_right.png
python3-skimage   usr/lib/python3/dist-packages/skimage/data/motorcycle_disp.npz%%arr_0.npy stereo/motorcycle_disp.npy
"
fi

as_root() {
  if [ "$(id -u)" = 0 ]; then "$@"; else sudo -n "$@"; fi
}

unpack() { # package: its files below $temporary/<package>
  [ -d "$temporary/$1" ] && return
  (cd "$temporary" && apt-get download -qq "$1" >/dev/null 2>&1) || {
    as_root apt-get update -qq
    (cd "$temporary" && apt-get download -qq "$1" >/dev/null)
  }
  dpkg -x "$temporary/$1"_*.deb "$temporary/$1"
}

printf '%s\n' "$list" | while read -r package file name; do
  [ -n "$package" ] || continue
  [ -s "$assets/$name" ] && continue
  unpack "$package"
  case $file in
    *//*) tar -xOf "$temporary/$package/${file%%//*}" "${file#*//}" >"$temporary/part" ;;
    *%%*) python3 -c 'import sys, zipfile; sys.stdout.buffer.write(zipfile.ZipFile(sys.argv[1]).read(sys.argv[2]))' \
      "$temporary/$package/${file%%\%\%*}" "${file#*%%}" >"$temporary/part" ;;
    *) cp "$temporary/$package/$file" "$temporary/part" ;;
  esac
  mkdir -p "$(dirname "$assets/$name")"
  mv "$temporary/part" "$assets/$name" # whole or not at all
  echo "fetched $name from $package"
done
