#!/usr/bin/env bash
# Compiles with Mono's mcs what Unity would: the core, its tests, the digest program, and the Unity side against stubs.
# Usage: build.sh OUT
set -euo pipefail
out="${1:?usage: build.sh OUT}"
mkdir -p "$out"
out="$(cd "$out" && pwd)"
cd "$(dirname "$0")"
mcs=(mcs -langversion:7 -warnaserror+ -optimize+ -debug "-lib:$out" -r:System.dll)

"${mcs[@]}" -target:library "-out:$out/Swellcast.Core.dll" Runtime/Core/*.cs
"${mcs[@]}" -r:Swellcast.Core.dll "-out:$out/Tests.exe" Tests/Console/*.cs
"${mcs[@]}" -r:Swellcast.Core.dll "-out:$out/Digest.exe" Tests/Digest/*.cs
# Type-checks only: nothing of the stubs does anything.
"${mcs[@]}" -target:library "-out:$out/UnityEngine.dll" Tests/Stubs/*.cs
"${mcs[@]}" -target:library -r:Swellcast.Core.dll -r:UnityEngine.dll "-out:$out/Swellcast.dll" Runtime/*.cs
# What the README shows: a script, and a program.
awk -v out="$out" '/^```csharp/ { shown = out "/Readme" ++count ".cs"; next } /^```/ { shown = "" } shown { print > shown }' README.md
"${mcs[@]}" -nowarn:0649 -target:library -r:Swellcast.Core.dll -r:Swellcast.dll -r:UnityEngine.dll "-out:$out/Readme1.dll" "$out/Readme1.cs"
"${mcs[@]}" -r:Swellcast.Core.dll "-out:$out/Readme2.exe" "$out/Readme2.cs"
echo "built into $out"
