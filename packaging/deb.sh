#!/bin/sh
# Builds the Debian package of nestd from a built binary: sh packaging/deb.sh [BINARY [OUT_DIR]]
# Needs dpkg-deb, and cargo for the notices. It holds the binary, the unit with its users and folders, the machines as examples, manual pages and completions.
set -eu
cd "$(dirname "$0")/.."
binary=${1:-target/release/nestd}
out=${2:-target/debian}
. packaging/version.sh
# Of one binary and commit the same package is made, byte for byte: times in it are not later than the commit.
SOURCE_DATE_EPOCH=${SOURCE_DATE_EPOCH:-$(git log -1 --format=%ct 2>/dev/null || echo 0)}
export SOURCE_DATE_EPOCH
arch=$(dpkg --print-architecture)
tree=$(mktemp -d)
trap 'rm -r "$tree"' EXIT
chmod 0755 "$tree"

put() { # MODE FILE PLACE
    install -D -m "$1" "$2" "$tree/$3"
}
put 0755 "$binary" usr/bin/nestd
strip --strip-unneeded "$tree/usr/bin/nestd"
put 0644 systemd/nestd.service usr/lib/systemd/system/nestd.service
put 0644 systemd/nestd-web.socket usr/lib/systemd/system/nestd-web.socket
put 0644 systemd/nestd.sysusers usr/lib/sysusers.d/nestd.conf
put 0644 systemd/nestd.tmpfiles usr/lib/tmpfiles.d/nestd.conf
doc=usr/share/doc/nestd
# Written to /etc/nestd by postinst, once: each farm changes it, and an upgrade must not ask about that.
put 0644 config/server/nestd.toml $doc/examples/nestd.toml
put 0644 config/nestd.toml $doc/nestd.toml
for machine in config/profiles/*.toml; do put 0644 "$machine" "$doc/examples/profiles/${machine##*/}"; done
# Placed as in the repository, so that their links work, except those to how nestd is made and measured.
for text in README.md systemd/README.md systemd/*.conf docs/*.md docs/*.png docs/screens/* docs/alerts.yml docs/grafana.json; do
    put 0644 "$text" "$doc/$text"
done
put 0644 packaging/copyright $doc/copyright
sh packaging/notices.sh >"$tree/$doc/third-party-notices.txt"
gzip -9n "$tree/$doc/third-party-notices.txt"

# What nestd says of itself.
"$tree/usr/bin/nestd" man "$tree/usr/share/man/man1" >/dev/null
mkdir -p "$tree/usr/share/man/man5"
mv "$tree/usr/share/man/man1/nestd.toml.5" "$tree/usr/share/man/man5"
gzip -9n "$tree"/usr/share/man/man[15]/*
mkdir -p "$tree/usr/share/bash-completion/completions" "$tree/usr/share/zsh/vendor-completions" "$tree/usr/share/fish/vendor_completions.d"
"$tree/usr/bin/nestd" completions bash >"$tree/usr/share/bash-completion/completions/nestd"
"$tree/usr/bin/nestd" completions zsh >"$tree/usr/share/zsh/vendor-completions/_nestd"
"$tree/usr/bin/nestd" completions fish >"$tree/usr/share/fish/vendor_completions.d/nestd.fish"
printf 'nestd (%s) unstable; urgency=medium\n\n  * See /usr/share/doc/nestd/NEWS.gz.\n\n -- nestd developers <nestd@users.noreply.github.com>  %s\n' "$version" "$(date -R -u -d "@$SOURCE_DATE_EPOCH")" |
    gzip -9n >"$tree/$doc/changelog.gz"
gzip -9nc CHANGELOG.md >"$tree/$doc/NEWS.gz"
find "$tree" -type d -exec chmod 0755 {} +
find "$tree/usr/share" -type f -exec chmod 0644 {} +

mkdir "$tree/DEBIAN"
for script in postinst prerm postrm; do install -m 0755 "packaging/$script" "$tree/DEBIAN/$script"; done
(cd "$tree" && find usr -type f -print0 | LC_ALL=C sort -z | xargs -0 md5sum >DEBIAN/md5sums)
# The oldest glibc whose symbols the binary names; everything else is linked in.
glibc=$(objdump -T "$tree/usr/bin/nestd" | sed -n 's/.*GLIBC_\([0-9.]*\)).*/\1/p' | sort -uV | tail -1)
cat >"$tree/DEBIAN/control" <<END
Package: nestd
Version: $version
Architecture: $arch
Maintainer: nestd developers <nestd@users.noreply.github.com>
Section: misc
Priority: optional
Depends: libc6 (>= ${glibc:-2.36}), libgcc-s1, libstdc++6, systemd (>= 250) | systemd-standalone-sysusers
Installed-Size: $(du -sk --apparent-size --exclude=DEBIAN "$tree" | cut -f1)
Homepage: https://github.com/nestd/nestd
Description: daemon that runs a powder-bed print farm
 Parts (STL, 3MF) that are dropped into the hot folder of a machine (SLS, MJF)
 are taken exactly once, collected, nested as low as possible, proved on their
 triangles, and put into the queue folder of the printer as one build file.
 .
 A dashboard shows what waits and what was built, and guides whoever breaks a
 build out.
END
mkdir -p "$out"
dpkg-deb --root-owner-group --build -Zxz "$tree" "$out/nestd_${version}_$arch.deb"
