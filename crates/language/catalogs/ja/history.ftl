a-state-of-build = ビルドの状態
the-number-of-build = ビルドの番号
is-no-date = 「{ $text }」は 2026-11-20 のような日付ではありません
csv-all-columns = 全列の CSV
next-builds = この続きのビルド
all = すべて
part-or-order = パーツまたは注文(完全な名前)
until = この日まで
sorted-by-what = 並べ替え
newest-first = 新しい順
show = 表示
days = { $days } 日間
published-in-time = この期間に発行したもの
heights = 高さ
the-newest-first = 新しい順
sorted-by =
    { $sort ->
        [height] 高さ順
        [density] 充填率順
        [copies] 個数順
       *[machine] 装置順
    }
no-builds = ビルドはありません
none-matches = 上の条件に合うものはありません。
all-builds = すべてのビルド
is-no-month = 「{ $text }」は 2026-10 のような月ではありません
as-many-days = { $month }の同じ日数
month-text = パーツのリットルは体積、ケーキのリットルは各ビルドの高さまでのパーツと粉末の合計です。装置時間は、高さに 1 mm あたりの時間を掛けたものです。歩留まりは、結果が記録された個のうちの良品の割合です。
height-by-week = 週ごとの高さ、mm
figure-builds =
    { $count ->
       *[other] ビルド
    }
figure-copies-made =
    { $count ->
       *[other] 個
    }
figure-of-parts = パーツの体積
figure-machine-time = 装置時間
figure-yield = 歩留まり
figure-late-parts = 遅れ
figure-failed =
    { $count ->
       *[other] 失敗
    }
none = なし。
link-on-machine = { $link }({ $machine })
month-caption = この月に発行したもの。小さい字は{ $before }の値
late = 遅れ
nothing-late = この月が納期のもので、遅れたものも遅れる見込みのものもありません。
late-text = 注文 { $orders } 件のパーツ { $parts } 件が、納期に遅れたか、まだ造形されていません。
without-order = 注文なし
done-about-untold = { $time } ごろ完了の見込み(結果が未記録)
done-at = { $time } 完了
chart-height = ビルドの高さ
chart-density = 充填率
chart-used = 装置の高さの使用率
more-machines = ほか装置 { $count } 台(表のみ)
height-curve = 探索中の高さ、mm と秒
height-over-time = 高さの推移
all-machines = すべての装置

costs = 費用
costs-by-order = 注文ごとの費用
costs-by-build = ビルドごとの注文の費用
costs-text = ビルドの装置時間と粉末は、部品の体積で分けます。リットルと個数は各注文のものです。不良品の分は工場が負担します。単価はビルドを作ったときのものです。粉末はビルドに使った新しい粉末です。
no-prices = 価格が設定されていません。単価は装置のファイルの `[costs]` にあります。
figure-cost = 費用
order-costs = これまでの費用は { $cost } です。
farm-bears-bad-copies = 不良品：工場が負担
csv-by-order = 注文ごとの CSV
csv-by-build = ビルドごとの CSV
this-month = 今月
