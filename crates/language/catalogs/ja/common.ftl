### Words of all pages: counts, dates, times.

## Dates

# A day near today: 12月4日(金).
date-day = { $month }{ $day }日({ $weekday })
# A day far from today: 2027年12月4日.
date-year = { $year }年{ $month }{ $day }日
# 2026年10月.
date-month = { $year }年{ $month }
date-today = 今日
date-tomorrow = 明日
date-yesterday = 昨日
# $day is one of the above; $clock is 05:49.
date-clock = { $day } { $clock }
# A time that nobody told.
about-time = { $time } ごろ
# On the axis of the board.
date-today-alone = 今日
# In a sentence to a customer: 12月4日(金曜日).
date-long = { $month }{ $day }日({ $weekday })
date-long-year = { $year }年{ $month }{ $day }日({ $weekday })
weekday-long =
    { $weekday ->
        [1] 月曜日
        [2] 火曜日
        [3] 水曜日
        [4] 木曜日
        [5] 金曜日
        [6] 土曜日
       *[7] 日曜日
    }
weekday-short =
    { $weekday ->
        [1] 月
        [2] 火
        [3] 水
        [4] 木
        [5] 金
        [6] 土
       *[7] 日
    }
month-short = { $month }月
month-long = { $month }月

## Durations

# $span is 3h 5m or 2d 2h, as it is written in all languages.
due-in = あと { $span }
due-overdue = { $span } 超過
# $delay is 40 分, 28 時間, 3 日.
late-by = { $delay }遅れ
delay-min = { $minutes } 分
delay-hours = { $hours } 時間
delay-days = { $days } 日

## Counts

count-copies = { $count } 個
count-parts = パーツ { $count } 件
count-files = ファイル { $count } 件
count-builds = ビルド { $count } 件
count-more-builds = ほかのビルド { $count } 件

## Labels of fields: headings of tables and of facts

field-build = ビルド
field-part = パーツ
field-machine = 装置
field-state = 状態
field-state-in-the-ledger = 台帳での状態
field-time = 時刻
field-question = 確認事項
field-reason = 理由
field-reason-or-warning = 理由または警告
field-note = メモ
field-height = 高さ
field-machine-height = 装置の高さ
field-bound = 下限
field-density = 充填率
field-mean-density = 平均充填率
field-used = 使用率
field-machine-time = 装置時間
field-parts = パーツ
field-cake = ケーキ
field-failed = 失敗
field-powder = 粉末
field-price = 価格
field-currency = 通貨
field-yield = 歩留まり
field-layers = 層数
field-layer = 層の厚さ
field-copies = 個数
field-copies-here = ここにある個数
field-copies-waiting = 待機中の個数
field-of = 全数
field-lines = 明細
field-wanted = 必要数
field-in-builds = ビルド内
field-queued = キュー内
field-printing = 造形中
field-printed = 造形済み
field-good = 良品
field-refused = 受付不可
field-bad = 不良
field-bad-copies = 不良の個体
field-cancelled = キャンセル済み
field-builds = ビルド
field-volume = 体積
field-clearance = 間隔
field-proved = 検証済みの間隔
field-cpu = CPU 時間
field-wall-time = 経過時間
field-evaluations = 評価回数
field-seed = シード
field-method = 方法
field-search = 探索
field-repeats = 再発行元
field-version = バージョン
field-fired-by = 確定のきっかけ
field-opened = 準備開始
field-nesting = 確定
field-verified = 検証
field-published = 発行
field-file = ファイル
field-file-or-reason = ファイルまたは理由
field-content = 内容
field-made = 作成
field-name = 名前
field-order = 注文
field-e-mail = メール
field-customer = 顧客
field-material = 材料
field-finishing = 仕上げ
field-lot = ロット
field-loaded = 入っている材料
field-priority = 優先度
field-due = 納期
field-claimed = 受付
field-orientation = 向き
field-size = 寸法
field-warning = 警告
field-where = 場所
field-origin-of-the-file-at = ファイル原点の位置
field-turned = 回転
field-break-out = 取り出し
field-mended = 修復
field-copy = 何個目
field-when = 日時
field-kind = 出来事
field-detail = 詳細
field-told = 記録
field-outcome = 結果
field-by = 記録者
field-printer = プリンター
field-free-from = 空き予定
field-since = いつから
field-print-times = 造形にかかる時間
field-fires = 確定予定
field-begins = 造形開始
field-unpacking = 取り出し予定
field-closed = 完了扱い
field-to-send = 送る文面
field-done = 完了
field-order-or-part = 注文またはパーツ
field-risk = 見通し
field-taken = プリンターの受け取り
field-released = 承認
field-reference = 参照番号
field-withdrawn = 取り下げ
field-waiting = 待機中
field-oldest = 最長の待機
field-next-build = 次のビルド
field-while-it-waits = 待機中の改善
field-node = ノード
field-host = ホスト
field-last-sign = 最後の応答
field-address = アドレス
field-machines = 装置
field-now = 現在
field-being-read = 読み取り中
field-last-published = 最後の発行
field-no = 番号
field-top = 上端
field-bottom = 下端
field-x = X
field-y = Y
field-way = 取り出し方向

## Words of states, as chips show them: of builds, machines, printers, copies, parts, orders and dates

state-complete = 完了
state-good = 良品
state-kept = 納期内
state-on-time = 納期内
state-done = 完了
state-runs = 動作中
state-printing = 造形中
state-should-be-printed = 造形済みの見込み
state-cooling = 冷却中
state-nesting = ネスティング中
state-being-made = 作成中
state-being-read = 読み取り中
state-reading = 読み取り中
state-under-way = 進行中
state-open = 準備中
state-waiting = 待機中
state-collecting = 収集中
state-queued = キュー内
state-in-the-queue = キュー内
state-at-the-printer = プリンター受領済み
state-proved = 検証済み
state-expecting = ビルド待ち
state-in-a-build = ビルド内
state-later = 後続
state-free = 空き
state-closed-now = 稼働時間外
state-withdrawn = 取り下げ済み
state-cancelled = キャンセル済み
state-closed = 完了扱い
state-stopped = 停止
state-no-date = 納期なし
state-tight = 余裕なし
state-ended = 終了見込み
state-should-be-done = 終了見込み
state-waits-for-a-yes = 承認待ち
state-paused = 一時停止
state-interrupted = 中断
state-short = 不足
state-missing = 見つからない
state-is-to-be-repaired = 要修復
state-on-its-way-to-another-printer = 別のプリンターへ移動中
state-being-taken-back = 取り下げ中
state-overdue = 納期超過
state-late = 遅れ
state-failed = 失敗
state-refused = 受付不可
state-bad = 不良
state-down = 使用停止
state-unavailable = 利用不可
state-does-not-answer = 応答なし
details = 詳細
close = 閉じる
skip = 本文へ移動
pages = ページ
nav-farm = ファーム
nav-orders = 注文
nav-history = 履歴
nav-month = 月次
nav-help = ヘルプ
search-farm = ファーム内を検索
footer-lengths = 。長さの単位は mm です。
footer-json = JSON インターフェース
footer-metrics = メトリクス
search-example = パーツ、注文、ビルド 3
search-key = / キーで検索
search = 検索
to-the-farm = ファームへ

## Titles of error pages

http-bad-request = 正しくない要求
http-unauthorized = 認証が必要
http-forbidden = 許可なし
http-not-found = 見つかりません
http-method-not-allowed = 使えない操作
http-conflict = 競合
http-payload-too-large = データが大きすぎます
http-misdirected-request = 宛先違いの要求
http-unprocessable-entity = 処理できない内容
http-too-many-requests = 要求が多すぎます
http-internal-server-error = サーバー内部のエラー
http-service-unavailable = 現在利用できません
http-error = エラー

## States of builds as the ledger has them

ledger-open = 準備中
ledger-nesting = ネスティング中
ledger-verified = 検証済み
ledger-published = 発行済み
ledger-printing = 造形中
ledger-complete = 完了
ledger-interrupted = 中断
ledger-failed = 失敗
ledger-claimed = 読み取り中
ledger-waiting = 待機中
ledger-batched = 作成中
ledger-built = ビルド済み
ledger-refused = 受付不可

## Kinds of events

event-in-a-build = ビルド内
event-in-the-queue = キュー内
event-waiting = 待機
event-refused = 受付不可
event-open = 準備開始
event-nesting = 確定
event-verified = 検証済み
event-published = 発行
event-printing = 造形中
event-complete = 完了
event-interrupted = 中断
event-failed = 失敗
event-paused = 一時停止
event-resumed = 再開
event-unavailable = 利用不可
event-available = 利用可能
event-adopted = 引き継ぎ
event-damaged = ファイル破損
event-size-differs = 寸法の相違
event-healed = ファイル復旧
event-at-risk = 遅れのおそれ
event-attempt-failed = 作成の失敗
event-proof-failed = 検証の失敗
event-locked = かみ合って抜けない
event-put-out = 配置から除外
event-no-room = 場所なし
event-clock-set = 時計の変更
event-messages-dropped = メッセージ破棄
event-put-back = 再び待機
event-copies-cancelled = 個数のキャンセル
event-copies-wanted = 個数の追加
event-edited = 変更
event-moved = 移動
event-loaded = 材料を記録
event-confirmed = 承認
event-finishing = 仕上げ
event-revised = 改訂
event-seen = 対応済み

## What fired a build

trigger-flush = 今すぐ確定
trigger-full = 満杯
trigger-fill = 設定の高さに到達
trigger-copies = 設定の個数に到達
trigger-max-wait = 待ち時間の上限
trigger-due = 納期
trigger-at = 確定時刻
trigger-withdrawn = ビルドの取り下げ

turned-free = 自由
turned-upright = 垂直軸まわりのみ
turned-axis = 直角単位
turned-fixed = ファイルのまま

## Signs between words

sign-comma = 、
sign-semicolon = 。
sign-stop = 。
sign-colon = :{ " " }

## The reason that lies beside a refused file

cause-and-reason = { $cause }(詳細は英語: { $reason })
reason-refused = { $name } は受付不可になりました。
reason-file = ファイル: { $place }
reason-when = 日時: { $time }
reason-part = 装置 { $machine } のパーツ { $part }。
reason-retry = 戻すには: nestd retry { $part }

# A build or a date with what is known of it.
job-described = { $name }: { $what }。
search-words-build = ビルド
search-words-part = パーツ ファイル
search-words-order = 注文
search-words-customer = 顧客
search-words-machine = 装置
