#!/bin/bash
# tests/architecture/bare-debian.sh: checks that a minimal Debian 12, with git and make only, can clone drover, run the
# demo and pass the tests.
#
#   [JOBS=n] tests/architecture/bare-debian.sh [BASE]
#
# Needs root.  BASE: a minimal Debian 12 tree to copy (debootstrap --variant=minbase --include=git,make bookworm BASE);
# by default debootstrap creates one from its own mirror or from $MIRROR.  Tests the last commit of this checkout in a
# temporary folder (about 3 GB), which is removed at the end; the packages come from the mirror.
set -euo pipefail

fail() {
    echo "bare-debian: $*" >&2
    exit 1
}

checkout=$(cd "$(dirname "$0")/../.." && pwd)
base=${1:-}
[ "$(id -u)" -eq 0 ] || fail "chroot and mount need root; run this by sudo."
[ -n "$base" ] || command -v debootstrap >/dev/null ||
    fail "debootstrap is not installed: apt-get install debootstrap, or give a BASE."
git=(git -c "safe.directory=*")
"${git[@]}" -C "$checkout" rev-parse --quiet --verify HEAD >/dev/null || fail "$checkout has no commit to clone."

root=$(mktemp --directory --tmpdir drover-bare-debian.XXXXXX)
clean_up() {
    local folder
    for folder in dev/shm dev/pts dev proc; do
        mountpoint --quiet "$root/$folder" && umount "$root/$folder"
    done
    # Never cross a mount that could not be unmounted: it may be the machine's /dev.
    rm --recursive --force --one-file-system "$root"
}
trap clean_up EXIT
trap 'exit 3' INT TERM

if [ -n "$base" ]; then
    cp --archive "$base/." "$root"
else
    debootstrap --variant=minbase --include=git,make bookworm "$root" ${MIRROR:+"$MIRROR"}
fi
chmod 755 "$root"
cp --dereference /etc/resolv.conf "$root/etc/resolv.conf"
mount -t proc proc "$root/proc"
mount -t tmpfs -o mode=755,dev tmpfs "$root/dev"
for device in "null 1 3" "zero 1 5" "full 1 7" "random 1 8" "urandom 1 9" "tty 5 0"; do
    read -r name major minor <<<"$device"
    mknod --mode=666 "$root/dev/$name" c "$major" "$minor"
done
ln --symbolic /proc/self/fd "$root/dev/fd"
mkdir "$root/dev/pts" "$root/dev/shm"
mount -t devpts -o newinstance,ptmxmode=666,mode=620,gid=5 devpts "$root/dev/pts"
ln --symbolic pts/ptmx "$root/dev/ptmx"
mount -t tmpfs -o mode=1777 tmpfs "$root/dev/shm"

# A clone owned by another user than the one who builds, as on a shared disk.
"${git[@]}" clone --quiet --no-hardlinks "$checkout" "$root/drover"
chown --recursive 65534:65534 "$root/drover"

inside() {
    echo "=== $*"
    local start=$SECONDS
    chroot "$root" /usr/bin/env --ignore-environment PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/root LANG=C.UTF-8 \
        ${JOBS:+JOBS="$JOBS"} \
        sh -c 'cd /drover && exec "$@"' sh "$@"
    echo "=== $*: done in $((SECONDS - start)) s"
}
inside make demo
inside make test
page=$root/drover/build/demo/index.html
for file in "$page" "${page%/*}/flock.png" "${page%/*}/particles.mp4"; do
    [ -s "$file" ] || fail "make demo left no ${file#"$root/drover/"}."
done
[ -z "$("${git[@]}" -C "$root/drover" status --porcelain)" ] ||
    fail "building left files that git sees: $("${git[@]}" -C "$root/drover" status --porcelain)"
echo "=== a bare Debian 12 reached ${page#"$root/drover/"} and passed the tests in $SECONDS s"
