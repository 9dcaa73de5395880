### Sentences about files, as they are stored in English: reading, meshes, sizes. Values named what, why, rest, remedy and formats are sentences themselves.
told-why-of = { $what }: { $why }
told-of-name = { $name }: { $why }
told-list = { $why }、{ $rest }
told-lists = { $why }。{ $rest }
told-list-and = { $why }。また、{ $rest }
told-mesh-formats = STL、3MF、OBJ、PLY
told-package-formats = STL、3MF

## Why a file cannot be read

told-cannot-read-file = ファイルを読み取れません
told-no-mesh-file = { $formats } のファイルではありません: { $what }
told-truncated = ファイルが途中で切れています: { $why }
told-truncated-detail = ファイルが途中で切れています(詳細は英語: { $detail })
told-invalid = 正しい { $format } ファイルではありません: { $why }
told-invalid-detail = 正しい { $format } ファイルではありません(詳細は英語: { $detail })
told-too-large = { $what }。上限は { $limit } です(limits.{ $key })
told-no-solid = { $name } は立体ではありません: { $why }
told-no-triangles = メッシュに三角形がありません
told-no-volume = メッシュが体積を囲んでいません
told-vertex-not-finite = 頂点 { $vertex } の座標が有限の数ではありません
told-triangle-not-finite = 三角形 { $triangle } の座標が有限の数ではありません
told-bad-index = 三角形 { $triangle } が頂点 { $vertex } を参照していますが、頂点は { $vertices } 個しかありません
told-far-vertex = { $name } の頂点 { $vertex } が原点から 1.05 km より離れています

## What to do with a file that cannot be read

told-copy-whole-again = ファイル全体をもう一度コピーしてください。元のファイルも切れている場合は、CAD から書き出し直してください。
told-export-binary = CAD からバイナリ形式({ $formats })で書き出し直してください。
told-make-smaller = 小さくするか、いくつかのファイルに分けて入れてください。または設定の limits.{ $key } を上げ、nestd を再読み込みして、ファイルをもう一度入れてください。
told-nothing-to-print-in-it = 造形できるものがありません。パーツそのものを、ソリッドまたは閉じたメッシュとして書き出してください。
told-no-thickness = 厚みのない面は造形できません。CAD で厚みを付けて書き出し直してください。
told-move-to-origin = CAD でパーツを原点に移すか、チケットで正しい単位を指定して、もう一度入れてください。
told-export-part-as = CAD からパーツを { $formats } で書き出し、それを入れてください。
told-unpack-formats = 展開して、中の { $formats } ファイルを入れてください。
told-unpack-files = 展開して、中のファイルを入れてください。
told-unpack-packages = 展開して、中のパッケージを入れてください。
told-save-plain-text = プレーンテキスト(ASCII または UTF-8)で保存するか、パーツをバイナリ STL で書き出してください。
told-no-shape-in-it = 造形できる形状がありません。パーツを { $formats } で入れてください。
told-get-from-server = ブラウザーで開いてサーバーの表示を確認し、サインインしてパーツをもう一度ダウンロードし、入れ直してください。
told-drop-right-extension = 正しい拡張子の { $formats } ファイルを入れてください。ほかの形式は CAD から書き出してください。
told-copy-again-or-export = もう一度コピーしてください。元のファイルも空の場合は、書き出し直してください。
told-git-lfs-pull = `git lfs pull` を実行してから入れてください。
told-drop-owner-file = 元になるファイルを入れてください。
told-delete-colours = 削除してください。OBJ ファイルは色なしで読み取られます。
told-export-core = パーツを通常の 3MF(コア仕様)または STL で書き出してください。
told-export-from-slicer-or-cad = 造形するものをスライサーまたは CAD から STL で書き出し、それを入れてください。
told-export-from-slicer = 造形するものをスライサーから STL で書き出し、それを入れてください。
told-beams-to-mesh = CAD でビームをメッシュに変換して書き出してください。
told-without-password = パスワードなしで保存し、それを入れてください。
told-save-plain-threemf = 書き出したソフトで開き、通常の 3MF で保存してください。
told-cut-in-slicer = スライサーで切り抜き(ブーリアン演算。オブジェクトの STL 書き出しでも切り抜かれます)、結果を確かめて入れてください。
told-make-model-volume = 造形するボリュームをスライサーでパーツにして、書き出し直してください。
told-same-unit = 両方で同じ単位を指定するか、単位を指定したチケットと一緒にパッケージを入れてください。
told-export-triangles = 三角形だけで、または STL か 3MF でパーツを書き出し直してください。
told-take-out-of-document = パッケージの文書からそれを除くか、モデル自体をチケットと一緒に、もう一度入れてください。

## What a file is in place of a part

told-file-is-empty = ファイルが空です
told-is-packed-amf = 圧縮された AMF ファイルです
told-is-zip-named = 拡張子が `.{ $named }` の ZIP です
told-is-text = `solid` のないテキストです
told-is-no-obj-text = OBJ ファイルのようなテキストではありません
told-no-ply-line = `ply` の行で始まっていません
told-first-bytes-no-extension = 先頭のバイトが不明で、名前に拡張子がありません
told-first-bytes-nor-name = 先頭のバイトも拡張子 `.{ $extension }` も不明です
told-is-lfs-pointer = ファイルそのものではなく、Git LFS のポインターです
told-is-utf16 = UTF-16 のテキストです
told-is-off = OFF ファイルです
told-is-appledouble = macOS の AppleDouble 付属ファイルです
told-is-step = STEP ファイルです
told-is-gltf = glTF ファイルです
told-is-xml = パッケージ外の XML です(AMF?)
told-is-web-page = パーツ本体ではなく Web ページ(HTML)です
told-is-pdf = PDF ファイルです
told-is-picture = 画像です
told-is-archive = 圧縮アーカイブです
told-is-cad = CAD のファイルです
told-is-colours = OBJ ファイルの色情報です
told-is-for-printer = パーツではなく、プリンター用のファイルです
told-is-document = 形状ではなく、テキストです
told-is-of-extension = { $what }(`.{ $extension }`)
told-is-zip-of-parts = パーツのファイルが入った ZIP です
told-is-package-in-package = パッケージの中のパッケージです

## What is wrong in a file

told-bytes-long = 長さが { $bytes } バイトです
told-separate-pieces = { $name } は { $pieces } 個の離れた部分からなります
told-too-many-triangles = 三角形が多すぎます
told-too-many-vertices = 頂点が多すぎます
told-too-many-objects = オブジェクトが多すぎます
told-too-many-components = コンポーネントが多すぎます
told-too-many-instances = コンポーネントのインスタンスが多すぎます
told-too-many-items = ビルド項目が多すぎます
told-too-deep = コンポーネントの入れ子が深すぎます
told-instances-triangles = 全インスタンスの三角形の合計が多すぎます
told-has-triangles = 三角形が { $count } 個あります
told-unpacked-too-large = 展開後のパッケージが大きすぎます
told-package-entries = パッケージに { $count } 個の項目があります
told-package-encrypted = パッケージが暗号化されています
told-package-damaged = ZIP パッケージが破損しています({ $detail })
told-package-packed = 3MF で認められない方法で圧縮されています({ $detail })
told-zip-end-missing = ZIP パッケージの終わりがありません
told-no-relationships = パッケージにリレーションがなく、3D モデルもありません
told-no-model = パッケージに 3D モデルがありません
told-no-build-items = ビルド項目がなく、造形するものがありません
told-no-item-to-print = 造形できるパーツのビルド項目がありません
told-no-object = オブジェクト { $object } がありません
told-component-of-itself = オブジェクト { $object } が自分自身のコンポーネントです
told-beam-lattice = オブジェクト { $object } はビームラティスです。形状が三角形ではなくビームで表されています
told-extension-required = 対応していないもの({ $what })が必要です: { $name }
told-an-extension = 拡張
told-encrypted-content = 暗号化された内容
told-negative-volume = { $name } に切り抜き用のネガティブボリューム { $volume } がありますが、nestd は切り抜きを行いません
told-no-model-volume = { $name } にはモデルのボリュームがなく、{ $left } だけです
told-manifest-unit = 単位が { $unit } ですが、マニフェストには { $other } とあります
told-header-too-short = { $bytes } バイトではバイナリ STL のヘッダーに足りません
told-only-triangles = 三角形 { $count } 個のうち { $present } 個しかありません
told-second-stl = 最初の STL の三角形 { $count } 個の後に、別の STL が続いています
told-ascii-follows = 三角形 { $count } 個の後に ASCII STL が続いています
told-more-triangles-follow = 三角形は { $count } 個のはずですが、さらに { $more } 個続いています
told-ends-within-facet = ファセット { $number } の途中で終わっています
told-ends-within-vertex = 頂点の途中で終わっています
told-ends-within-line = { $number } 行目の途中で終わっています
told-ends-in-line = { $number } 行目で終わり、{ $wanted } がありません
told-line-why = { $number } 行目: { $why }
told-facet-vertices = ファセット { $number } の頂点が 3 個ではなく { $found } 個です
told-expected-found = { $wanted } のはずが { $found } です
told-unfinished-copy = コピーが途中です: { $why }
told-ends-in-zeros = 末尾がゼロです
told-zeros-from = { $at } バイト目以降がすべてゼロです
told-zeros-in-line = { $number } 行目にゼロがあります
told-last-zeros = 三角形 { $count } 個のうち最後の { $run } 個がゼロです
told-zeros-between = 三角形 { $count } 個のうち { $first } から { $last } までがゼロです
told-no-face = 面がありません。点と線だけでは造形できません
told-no-face-points = 面がありません。点だけでは造形できません
told-free-form-surface = 自由曲面が含まれています
told-free-form-curve = 自由曲線が含まれています
told-names-other-file = 付属する別のファイルを参照しています
told-in-line = { $what }({ $number } 行目)
told-ends-before-header = `end_header` の前で終わっています
told-entries-of = 要素 { $name } の項目 { $all } 個のうち { $count } 個しかありません

## Why a part cannot be printed on a machine

told-not-closed = { $name }: メッシュが閉じておらず({ $why })、どこが内側かわかりません。補修しない理由: { $rest }。修復するか、装置 { $machine } で mesh_errors = "warn" を設定してください。
told-mendable = { $name }: メッシュが閉じておらず({ $why })、どこが内側かわかりません。補修できます: { $what }。{ $remedy }
told-mend-remedy = `nestd mend { $part }` またはパーツのページのボタンで、補修して造形します。
told-mend-remedy-ticket = チケットに mend = true と書くと、補修して造形します。
told-mend-holes = 最大 { $mm } mm の穴 { $n } か所をふさぐ
told-mend-added = 三角形 { $n } 個を追加
told-mend-turned = 三角形 { $n } 個を反転
told-mend-left-out = 三角形 { $n } 個を除外
told-mend-joined = 頂点 { $n } 個を結合
told-mend-volume = 体積 { $before } -> { $now } cm³
told-mend-off = 元の表面からのずれは最大 { $mm } mm
told-not-mended-closed = メッシュは閉じています
told-not-mended-too-large = 三角形または穴が多すぎます
told-not-mended-ambiguous = 3 個以上の三角形が接する辺で、どれが組になるかわかりません
told-not-mended-one-sided = 表裏のない部分があります
told-not-mended-large-hole = 幅 { $mm } mm の穴は大きすぎて、元の形がわかりません
told-not-mended-opening = 幅 { $mm } mm の開口部は周囲がすべて鋭い縁で、意図されたものかもしれません
told-not-mended-crossing = 穴をふさぐ面が表面と交差します
told-not-mended-doubt = 穴の周りの曲がりが大きく、元の形がわかりません
told-not-mended-sheet = 体積のない面だけの部分があります
told-not-mended-cavity = 別の部分の内側にある部分が空洞かどうかわかりません
told-open-edges = 開いたエッジ { $n } 本
told-non-manifold-edges = 3 つ以上の三角形が共有するエッジ { $n } 本
told-inconsistent-edges = 三角形の向きが逆のエッジ { $n } 本
told-too-many-copies = { $copies } 個が指定されていますが、1 つのファイルで指定できるのは { $limit } 個までです(limits.max_copies)。個数を減らして入れ直すか、設定でこの上限を上げて nestd を再読み込みしてください。
told-needs-more-room = { $name }: 許可された最良の向き({ $rule })でも { $x } x { $y } x { $z } mm 必要です。{ $machine } の造形範囲は { $a } x { $b } x { $c } mm です。{ $remedy }
told-larger-machine = より大きな装置に入れるか、分割してください。チケットで直立や固定を指定している場合は、向きの制限を緩めると入ることがあります。
told-other-unit-fits = { $unit } として読むと { $x } x { $y } x { $z } mm になり、入ります。その単位のつもりであれば、unit = "{ $unit }" と書いたチケットと一緒に入れてください。
told-no-rotation = { $name }: 向きの指定({ $rule })をすべて満たす回転がありません。チケットから 1 つ除き、両方をもう一度入れてください。
told-no-place-alone = 試しましたが、{ $machine } の空の造形範囲に配置できませんでした。より大きな装置に入れるか、チケットで向きの制限を緩めるか clearance_mm を小さくしてください。
told-search-failed = このパーツで探索が失敗しました({ $detail })。戻してもう一度試し、それでも失敗する場合は書き出し直してください。
told-reader-failed = 読み取りに失敗しました({ $detail })。{ $formats } で書き出し直し、それでも失敗する場合は nestd の開発元に送ってください。
told-read-timeout = { $name }: 読み取りで nestd が 2 回終了し、別プロセスでも { $minutes } 分で読み終わりませんでした。三角形や部分を減らして書き出し、もう一度入れてください。
told-read-crash = { $name }: 読み取りで nestd が 2 回終了し、メモリー { $bytes } バイト(limits.read_memory_bytes)の別プロセスも{ $what }終了しました。三角形や部分を減らして書き出してもう一度入れるか、この上限を上げて戻してください。
told-by-signal = シグナル { $signal } で
told-with-exit-code = 終了コード { $code } で
told-file-not-kept = ファイルはもう保管されていません。もう一度入れてください。
told-file-not-here = nestd に完全なファイルが残っていないため、ここにはありません({ $detail })。
told-size-differs = { $name } は最初の読み取りでは { $before } mm でしたが、今は { $now } mm です
told-mend-differs = { $name } のメッシュが最初の読み取りと同じように補修されません
told-stored-missing = 保管した { $name } のファイルがありません
told-stored-damaged = 保管した { $name } のファイルが破損していたため、{ $aside } として除けました

## Warnings about a file

told-mesh-not-closed = メッシュが閉じていません: { $why }。
told-mended-by = { $who } の許可により、メッシュを補修しました: { $what }。
told-mended-by-person = { $name } の許可により、メッシュを補修しました: { $what }。
told-mend-by-ticket = チケット
told-mend-by-setting = 装置の設定 mesh_errors
told-far-from-origin = 座標がファイルの原点から遠く、32 ビットの数値の間隔が { $step } mm になっています。細部がその分ずれることがあります。CAD で原点に移して書き出し直してください。
told-turned-inside-out = 表裏が逆だった面を反転しました
told-suspicious-size = サイズが疑わしい値です: { $unit } として読むと最大寸法は { $size } mm です(ほかの単位、英語: { $detail })
told-no-endsolid = ファイルに `endsolid` がありません。終わりが欠けている可能性があります
told-several-solids = ファイルに { $solids } 個の立体があり、三角形 { $facets } 個の 1 つのパーツとして扱います
told-objects-one-part = ファイルに { $objects } 個のオブジェクトがあり、1 つのパーツとして扱います
told-bytes-ignored = 最後の三角形の後の { $n } バイトは無視します
told-duplicate-pieces = 同じ位置に重複した部分があります: 1 つずつ残し、三角形 { $left } 個を除きました
told-ticket-unit-used = ファイルの単位 { $other } の代わりに、チケットの単位 { $unit } を使います
told-left-out-volumes = モデルのボリュームではないため除外: { $names }
told-slice-stack = このパーツのスライスデータもファイルにありますが、無視します。三角形は近似にすぎない可能性があります
told-left-out-unprintable = 造形対象外のビルド項目 { $n } 個を除きました
told-left-out-helpers = サポートなどの補助用ビルド項目 { $n } 個を除きました
told-items-touch = { $why }。このままでは項目ごとに別のパーツとして配置されます(一体のものは、1 つのオブジェクトまたは STL にまとめて入れてください)
told-items-stacked = ビルド項目 { $n } 個のうち { $stacked } 個が同じ位置にあります
told-item-touches = ファイル内で { $name } に接触または貫通しています
told-too-many-items-to-see = ビルド項目が多すぎて、接触しているか確かめられません

## What a person must confirm

told-is-speck = { $x } x { $y } x { $z } mm で、{ $least } mm より小さくなっています
told-is-speck-inches = { $x } x { $y } x { $z } mm で、{ $least } mm より小さくなっています。ミリではなくインチとして読むと { $a } x { $b } x { $c } mm です
told-is-thin = { $x } x { $y } x { $z } mm で、1 層 { $layer } mm より薄くなっています

## Why a ZIP archive was not unpacked

told-archive-cannot = このアーカイブは展開できません: { $detail }。パスワードのない普通の ZIP として作り直すか、展開してフォルダーを入れてください。
told-archive-twice = このアーカイブには同じファイルが 2 回あります。展開してフォルダーを入れてください。
told-archive-names-twice = このアーカイブには「{ $name }」が 2 回あります。展開してフォルダーを入れてください。
told-archive-too-large = このアーカイブは展開すると上限を超えます(`max_unpacked_bytes` = { $limit }、1 ファイルは元の { $times } 倍まで)。展開してフォルダーを入れてください。
told-archive-entries = このアーカイブの項目は { $entries } 個で、上限は { $limit } 個です(`max_entries`)。展開してフォルダーを入れてください。
told-archive-in-archive = このアーカイブの中に別のアーカイブ「{ $name }」があります。両方を展開してフォルダーを入れてください。
told-archive-empty = このアーカイブにはファイルがありません。パーツを入れて、もう一度入れてください。
told-archive-outside = このアーカイブは外のファイル「{ $name }」を指しています。展開して、必要なファイルを入れてください。
told-archive-link = このアーカイブはリンク「{ $name }」を含みます。展開して、必要なファイルを入れてください。
