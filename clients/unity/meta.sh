#!/usr/bin/env bash
# Unity ignores files of a package that have no .meta beside them, so each has one; its GUID is the MD5 of the package's
# name and the path, the same on every machine. Usage: meta.sh writes those that are missing; meta.sh --check fails for them.
set -euo pipefail
cd "$(dirname "$0")"
missing=0
# Unity looks at no name that begins with a dot or ends with a tilde.
while read -r path; do
    path="${path#./}"
    [ ! -e "$path.meta" ] || continue
    missing=1
    if [ "${1:-}" = --check ]; then
        echo "no $path.meta: run clients/unity/meta.sh" >&2
        continue
    fi
    guid="$(printf 'com.swellcast.client/%s' "$path" | md5sum | cut -c1-32)"
    {
        echo 'fileFormatVersion: 2'
        echo "guid: $guid"
        [ ! -d "$path" ] || echo 'folderAsset: yes'
        case "$path" in
            *.cs) importer=MonoImporter ;;
            *.asmdef) importer=AssemblyDefinitionImporter ;;
            package.json) importer=PackageManifestImporter ;;
            *.md) importer=TextScriptImporter ;;
            *) importer=DefaultImporter ;;
        esac
        echo "$importer:"
        echo '  externalObjects: {}'
        if [ "$importer" = MonoImporter ]; then
            printf '  serializedVersion: 2\n  defaultReferences: []\n  executionOrder: 0\n  icon: {instanceID: 0}\n'
        fi
        printf '  userData: \n  assetBundleName: \n  assetBundleVariant: \n'
    } >"$path.meta"
done < <(find . -mindepth 1 -not -path '*/.*' -not -name '*~' -not -path '*~/*' -not -name '*.meta' | sort)
for meta in $(find . -name '*.meta'); do
    [ -e "${meta%.meta}" ] || { echo "$meta stands beside nothing" >&2; missing=1; }
done
[ "${1:-}" != --check ] || exit "$missing"
