#!/bin/sh
# Makes the font of the pages, a Latin part of Inter with the weights 400 to 700, and that of labels, its European letters with the kana and the
# few other signs of Noto Sans JP that labels say: sh src/web/assets/font.sh. Needs npm, python3 and a network.
set -eu
cd "$(dirname "$0")"
out=$(mktemp -d)
trap 'rm -r "$out"' EXIT
(cd "$out" && npm pack --silent @fontsource-variable/inter@5.3.0 >/dev/null && tar xzf ./*.tgz &&
    python3 -m venv python && python/bin/pip -q install fonttools==4.68.0 brotli==1.2.1)
"$out/python/bin/fonttools" varLib.instancer "$out/package/files/inter-latin-wght-normal.woff2" wght=400:700 -o "$out/inter.ttf"
"$out/python/bin/pyftsubset" "$out/inter.ttf" --flavor=woff2 --layout-features=kern,mark,mkmk,tnum,ccmp,locl --output-file=inter.woff2 \
    --unicodes=U+0020-007E,U+00A0-00FF,U+0131,U+0152-0153,U+02C6,U+02DA,U+02DC,U+2013-2014,U+2018-201A,U+201C-201E,U+2022,U+2026,U+2032-2033,U+2039-203A,U+20AC,U+2122,U+2190-2193,U+2212,U+2215
cp "$out/package/LICENSE" LICENSE-Inter
(cd "$out" && rm -r package ./*.tgz && npm pack --silent inter-ui@4.1.1 >/dev/null && tar xzf ./*.tgz)
"$out/python/bin/fonttools" ttLib.woff2 decompress -o "$out/medium.ttf" "$out/package/web/Inter-Medium.woff2"
"$out/python/bin/pyftsubset" "$out/medium.ttf" --output-file="$out/europe.ttf" --layout-features= --no-hinting --notdef-outline --name-IDs= --drop-tables+=GSUB,GPOS,GDEF,STAT \
    --unicodes=U+0020-007E,U+00A0-017F,U+0218-021B,U+0370-03FF,U+0400-045F,U+0490-0491,U+2013-2014,U+2018-201E,U+2020-2022,U+2026,U+2030,U+2032-2033,U+2039-203A,U+20AC,U+2122,U+2190-2193,U+2212
(cd "$out" && rm -r package ./*.tgz && npm pack --silent @expo-google-fonts/noto-sans-jp@0.4.3 >/dev/null && tar xzf ./*.tgz package/500Medium/NotoSansJP_500Medium.ttf package/LICENSE_FONT)
cp "$out/package/LICENSE_FONT" LICENSE-NotoSansJP
"$out/python/bin/pyftsubset" "$out/package/500Medium/NotoSansJP_500Medium.ttf" --output-file="$out/japan.ttf" --layout-features= --no-hinting --name-IDs= --drop-tables+=GSUB,GPOS,GDEF,STAT,BASE,vhea,vmtx,VORG,DSIG,gasp \
    --unicodes=U+3001-3002,U+300C-300D,U+3041-3096,U+30A1-30FC --text=仕分箱注文個件納期袋年月日火水木金土曜今明昨
"$out/python/bin/python" - "$out" <<'END'
import sys
from fontTools.merge import Merger
from fontTools.ttLib import TTFont
from fontTools.ttLib.scaleUpem import scale_upem
out = sys.argv[1]
europe, japan = TTFont(f"{out}/europe.ttf"), TTFont(f"{out}/japan.ttf")
scale_upem(japan, europe["head"].unitsPerEm)
japan.save(f"{out}/japan.ttf")
both = Merger().merge([f"{out}/europe.ttf", f"{out}/japan.ttf"])
# Lines are as high as without the Japanese signs.
for name in ("ascent", "descent", "lineGap"):
    setattr(both["hhea"], name, getattr(europe["hhea"], name))
both["OS/2"] = europe["OS/2"]
both.save("labels.ttf")
END
