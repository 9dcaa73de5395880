# Sourced by the scripts beside it: `version` is that of the package. Between releases it has the number of commits: a newer package is
# installed over an older one, and the release over both.
version=$(sed -n '/^\[workspace.package\]/,/^\[/s/^version = "\(.*\)"/\1/p' Cargo.toml)
if [ -e .git ] && ! git describe --exact-match --match "v$version" HEAD >/dev/null 2>&1; then
    version="$version~dev.$(git rev-list --count HEAD)+g$(git rev-parse --short=10 HEAD)"
fi
