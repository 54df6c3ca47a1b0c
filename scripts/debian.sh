#!/usr/bin/env bash
# Sees to it that Debian packages are there: installs the missing ones as root, otherwise names them.
# Without root it succeeds all the same, so that what can run does, unless --required stands first.
set -u
required=0
[ "${1:-}" = --required ] && { required=1; shift; }
missing=()
for package in "$@"; do
    dpkg-query -W -f '${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || missing+=("$package")
done
[ ${#missing[@]} -eq 0 ] && exit 0
if [ "$(id -u)" = 0 ] && command -v apt-get >/dev/null; then
    export DEBIAN_FRONTEND=noninteractive
    apt-get update -qq && apt-get install -y -qq --no-install-recommends "${missing[@]}" >/dev/null && exit 0
fi
echo "missing Debian packages; as root: apt-get install ${missing[*]}" >&2
exit $required
