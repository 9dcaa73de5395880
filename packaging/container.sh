#!/bin/sh
# Builds the container image of nestd from a built binary: sh packaging/container.sh [BINARY [OUT_DIR]]
# Needs buildah, mmdebstrap, strip and cargo (for the notices), and the packages of the distribution of this machine. The image has the
# libraries that the binary names, time zones and certificates with what these depend on, and no shell.
set -eu
cd "$(dirname "$0")/.."
binary=${1:-target/release/nestd}
out=${2:-target/container}
. packaging/version.sh
suite=$(sed -n 's/^VERSION_CODENAME=//p' /etc/os-release)
arch=$(dpkg --print-architecture)
tree=$(mktemp -d)
trap 'rm -r "$tree"' EXIT
mkdir -p "$out"

mmdebstrap --quiet --variant=extract --include=libc6,libgcc-s1,libstdc++6,tzdata,ca-certificates,base-files,netbase \
    "$suite" "$tree/base.tar"
mkdir "$tree/base" "$tree/root"
tar -C "$tree/base" --exclude='./var/lib/*' --exclude='./var/cache/*' --exclude='./dev/*' -xf "$tree/base.tar"
cat "$tree"/base/usr/share/ca-certificates/mozilla/*.crt >"$tree/base/etc/ssl/certs/ca-certificates.crt"
rm -r "$tree/base/usr/share/man" "$tree/base/usr/share/ca-certificates"
install -D -m 0755 "$binary" "$tree/root/usr/bin/nestd"
strip --strip-unneeded "$tree/root/usr/bin/nestd"
install -D -m 0644 packaging/copyright "$tree/root/usr/share/doc/nestd/copyright"
sh packaging/notices.sh >"$tree/root/usr/share/doc/nestd/third-party-notices.txt"
gzip -9n "$tree/root/usr/share/doc/nestd/third-party-notices.txt"
mkdir "$tree/root/etc" "$tree/farm"
echo 'nestd:x:7878:7878:nestd:/farm:/usr/sbin/nologin' >"$tree/root/etc/passwd"
echo 'nestd:x:7878:' >"$tree/root/etc/group"

# Plain layers: nothing runs while they are made. The folders of the host know the account by its number.
image=$(buildah from scratch)
buildah add --quiet "$image" "$tree/base" / >/dev/null
buildah add --quiet "$image" "$tree/root" / >/dev/null
buildah add --quiet --chown 7878:7878 "$image" "$tree/farm" /farm >/dev/null
buildah config --user 7878:7878 --workingdir /farm --volume /farm --entrypoint '["/usr/bin/nestd"]' --cmd run \
    --label org.opencontainers.image.title=nestd --label "org.opencontainers.image.version=$version" \
    --label org.opencontainers.image.licenses='MIT OR Apache-2.0' "$image"
file=$out/nestd_${version}_$arch.oci.tar
buildah commit --quiet --rm "$image" "oci-archive:$file:localhost/nestd:latest" >/dev/null
echo "$file"
