#!/usr/bin/env bash
# The README's commands on a Debian 12 that has nothing installed: a fresh system in a folder, the committed
# state of this clone in it, first with the network that apt needs, then once more with none at all.
#   tools/bare_machine.sh [demo|user|test]...   (default: demo user)
#     demo  tools/demo.sh as root, then again offline with a new build folder
#     user  tools/demo.sh as a user with sudo, in a system of its own
#     test  tools/test.sh as root, with $VILDAR_SHARED (default ../shared) beside it where that exists
# Needs root, debootstrap and unshare, the mirror of Debian 12 that apt is set up with here, and 4 GB below
# $BARE_ROOT (default /var/tmp). Everything made there is removed at the end.
set -euo pipefail
cd "$(dirname "$0")/.."

skip() {
  echo "tools/bare_machine.sh: SKIPPED: $1" >&2
  exit 77
}
[[ $(id -u) == 0 ]] || skip "making a system in a folder needs root"
for command in debootstrap unshare; do
  command -v "$command" >/dev/null || skip "$command is missing (apt-get install debootstrap util-linux)"
done
jobs=("$@")
((${#jobs[@]})) || jobs=(demo user)
for job in "${jobs[@]}"; do
  [[ $job =~ ^(demo|user|test)$ ]] || { echo "tools/bare_machine.sh: no job \"$job\" (demo, user, test)" >&2; exit 2; }
done
# The mounts below belong to a name space of their own and go when the script ends, however it ends.
[[ ${VILDAR_BARE_MOUNTS:-} == own ]] ||
  VILDAR_BARE_MOUNTS=own exec unshare --mount --propagation private bash tools/bare_machine.sh "${jobs[@]}"

mirror=$(apt-get indextargets --format '$(REPO_URI) $(RELEASE) $(COMPONENT)' 'Identifier: Packages' |
  awk '$2 == "bookworm" && $3 == "main" {print $1; exit}')
[[ -n "$mirror" ]] || skip "apt has no mirror of Debian 12 (bookworm main) set up"
shared=$(realpath -m "${VILDAR_SHARED:-../shared}")

place=$(mktemp -d "${BARE_ROOT:-/var/tmp}/vildar_bare.XXXXXX")
root=$place/system
remove() {  # never across a mount: --one-file-system, and only once nothing is mounted below
  for point in dev proc shared; do umount "$root/$point" 2>/dev/null || true; done
  if ! grep -q " $place/" /proc/self/mounts; then rm -rf --one-file-system "$1"; fi
}
trap 'remove "$place"' EXIT

new_system() {  # a fresh system with this clone in /vildar
  remove "$root"
  cp -a "$place/base" "$root"
  cp -L /etc/resolv.conf "$root/etc/resolv.conf"
  for setting in /etc/apt/apt.conf.d/*proxy*; do
    if [[ -f $setting ]]; then cp "$setting" "$root/etc/apt/apt.conf.d/"; fi
  done
  mount -t proc proc "$root/proc"
  mount -t tmpfs -o mode=755 devices "$root/dev"
  mknod -m 666 "$root/dev/null" c 1 3
  mknod -m 666 "$root/dev/zero" c 1 5
  mknod -m 666 "$root/dev/full" c 1 7
  mknod -m 666 "$root/dev/random" c 1 8
  mknod -m 666 "$root/dev/urandom" c 1 9
  ln -s /proc/self/fd "$root/dev/fd"
  git clone -q --no-hardlinks . "$root/vildar"
}

timed() {  # LABEL COMMAND...: runs, says how long it took
  local label=$1 began=$SECONDS
  shift
  "$@" || { echo "FAILED: $label" >&2; exit 1; }
  echo "== $label: $((SECONDS - began)) s"
}

disk_mb() { du -smx "$root" | cut -f1; }

debootstrap --variant=minbase bookworm "$place/base" "$mirror" >"$place/debootstrap.log"
for job in "${jobs[@]}"; do
  new_system
  bare_mb=$(disk_mb)
  case "$job" in
    demo)
      timed "packages alone" chroot "$root" /vildar/tools/setup.sh
      timed "demo.sh as root, packages installed" chroot "$root" /vildar/tools/demo.sh
      echo "== disk: $(($(disk_mb) - bare_mb)) MB more than the bare system"
      rm -rf "$root/vildar/build" "$root/vildar/demo_out"
      timed "demo.sh once more, without a network" unshare --net chroot "$root" /vildar/tools/demo.sh
      ;;
    user)
      chroot "$root" sh -c 'apt-get -qq update && apt-get -qq install -y --no-install-recommends sudo >/dev/null &&
        useradd --create-home driver && echo "driver ALL=(ALL) NOPASSWD: ALL" >/etc/sudoers.d/driver && chown -R driver /vildar'
      timed "demo.sh as a user with sudo" chroot --userspec=driver "$root" env HOME=/home/driver /vildar/tools/demo.sh
      ;;
    test)
      if [[ -d $shared ]]; then mkdir "$root/shared" && mount --bind -o ro "$shared" "$root/shared"; fi
      timed "test.sh as root, nothing installed" chroot "$root" /vildar/tools/test.sh
      ;;
  esac
done
