### Sentences of the farm, as they are stored in English: details of alerts, builds that failed, events, answers to commands.

## Errors of the operating system

told-os-gone = ファイルまたはフォルダーがありません(エラー 2)
told-os-io = 入出力エラー(エラー 5)
told-os-denied = 許可がありません(エラー 13)
told-os-exists = ファイルがすでにあります(エラー 17)
told-os-other-device = 別のファイルシステムです(エラー 18)
told-os-no-directory = フォルダーではありません(エラー 20)
told-os-is-directory = フォルダーです(エラー 21)
told-os-full = ディスクに空きがありません(エラー 28)
told-os-read-only = 読み取り専用のファイルシステムです(エラー 30)
told-os-not-connected = 接続されていません(エラー 107)
told-os-timed-out = 接続がタイムアウトしました(エラー 110)
told-os-host-down = ホストが停止しています(エラー 112)
told-os-stale = 古いファイルハンドルです(エラー 116)
told-os-quota = ディスクの割り当てを超えました(エラー 122)
told-os-other = OS のエラー { $number }({ $error })

## Folders

told-reading-path = { $path } の読み取り: { $why }
told-listing-path = { $path } の一覧: { $why }
told-creating-path = { $path } の作成: { $why }
told-cannot-write = { $path } に書き込めません: { $why }
told-cannot-be-used = { $path } を使えません: { $why }
told-queue-unavailable = キューフォルダー { $path } を利用できません: { $why }
told-inbox-unavailable = ホットフォルダー { $path } を利用できません: { $why }
told-queue-not-available = キューフォルダーを利用できなくなりました
told-it-is-not-there = 見つかりません
told-it-is-no-folder = フォルダーではありません
told-it-cannot-be-listed = 一覧を取得できません
told-marker-empty = 目印の .nestd-queue が空です
told-other-file-system = 最初と違うファイルシステムにあります。マウントし直すか、nestd を再起動してください
told-file-system-changed = 一覧の取得中にファイルシステムが変わりました
told-served-by-other = { $path } は別の nestd が担当しています: { $host } のプロセス { $pid }({ $since } から、状態フォルダー { $state })。それを停止するか、ファームごとに別のフォルダーを割り当ててください
told-folder-replaced = { $path } は以前のフォルダーではありません: 目印の { $marker } がありません。マウントし直してください。意図して置き換えたか空にした場合: touch { $file }
told-holds-more-files = { $path }: ファイルが { $most } 件を超えています。残りは待機します
told-other-file-system-inside = { $path }: 別のファイルシステムなので、パーツを受け付けられません
told-recycle-bin = { $path }: 名前がごみ箱なので、中のものは造形されません
told-folder-denied = { $path }: 許可がないため読み取れません
told-cannot-be-read-path = { $path } を読み取れません
told-file-damaged-hash = { $path } が破損しています: 内容がハッシュと一致しません

## Details of alerts

told-and-more = { $why }。ほか { $more } 件
told-and-more-comma = { $why }、ほか { $more } 件
told-and-more-parts = { $why }、ほか { $more } 件
told-files-in = { $n } 件(フォルダー: { $path })
told-files-beside = { $name }(フォルダー: { $path })
told-files-beside-more = { $name }、ほか { $more } 件(フォルダー: { $path })
told-in-claimed = .claimed フォルダーに { $files } 件
told-part-named = パーツ { $part }({ $file })
told-part-asks = パーツ { $part }({ $file }): { $why }
told-build-named = ビルド { $build }
told-build-why = ビルド { $build }: { $why }
told-release-brief = { $n } 個、高さ { $height } / { $limit } mm、充填率 { $density } %、造形 約 { $hours } 時間
told-node-serves-it = ノード { $node } が担当しています
told-node-is-gone = 担当ノード { $node } が動いていません
told-node-with-machines = { $host } の { $node }（{ $names }）
told-gone-with-work = パーツ { $parts } 件、作成中のビルド { $builds } 件
told-gone-with-lines = { $why }、プログラムからの注文明細 { $n } 件
told-ended-during-search-more = ビルド { $build } の探索中に nestd が { $times } 回終了しました。次の探索は起動の { $secs } 秒後に始まります。パーツは { $names } ほか { $more } 件です。`nestd cancel PART` で取り除けます
told-ended-during-search = ビルド { $build } の探索中に nestd が { $times } 回終了しました。次の探索は起動の { $secs } 秒後に始まります。パーツは { $names } です。`nestd cancel PART` で取り除けます
told-printer-configured-no-more = プリンター { $printer } は設定からなくなりましたが、{ $file } がビルド { $build } としてそのキューフォルダーに残っている可能性があります
told-step-obeying = 制御ファイルの実行
told-step-recording-drop = 受付の記録
told-step-recording-refusal = 受付不可の記録
told-step-late-ticket = 後から届いたチケットの適用
told-step-originals = 元ファイルの取得
told-step-command = コマンド { $number }

## Files in a queue

told-queue-other-machine = { $file } は { $machine } のビルド { $build } です。{ $machine } のキューに移してください
told-queue-not-proved = { $file } はビルド { $build } として検証されたファイルではありません。取り出し、造形されたか確かめて、ビルド { $build } の結果を記録してください
told-queue-does-not-fit = { $file } は装置に合いません({ $detail })。`nestd withdraw { $build }` で取り下げると、今の装置に合わせてネスティングします
told-queue-second-on-way = { $file } は、キューから取り下げ中のビルド { $build } の 2 つ目のファイルです。取り出してください
told-queue-second-lies-at = { $file } は、{ $printer } にあるビルド { $build } の 2 つ目のファイルです。取り出してください
told-queue-second-taken-out = { $file } は、{ $printer } のキューから出たビルド { $build } の 2 つ目のファイルです。そちらを造形する場合はこのファイルを取り出し、移動しただけの場合は `nestd dismiss b{ $build }` を実行してください
told-queue-failed-file = { $file } はビルド { $build }({ $what })のファイルです。取り出さないと 2 回造形されます
told-queue-failed-complete = { $file } はビルド { $build }({ $what })のファイルです。取り出さないと 2 回造形されます。すでに造形された場合は `nestd outcome { $build } complete --correct` で記録してください
told-queue-failed-withdrawn = { $file } はビルド { $build }({ $what })のファイルです。取り出さないと 2 回造形されます。すでに造形された場合は、待機中から同じ数を `nestd cancel PART=N` で除いてください(`nestd show b{ $build }` にパーツが出ます)
told-queue-was-out-before = { $file } は、一度キューから出たビルド { $build }({ $what })のファイルです。取り出してください
told-word-printing = 造形中
told-word-complete = 完了
told-word-interrupted = 中断
told-word-failed = 失敗
told-word-withdrawn = 取り下げ済み
told-word-published = 発行済み

## Builds that failed or went back

told-build-gave-up = ビルド { $build } は { $n } 回失敗したため中止: { $why }
told-build-gave-up-detail = ビルド { $build } は { $n } 回失敗したため中止(詳細は英語: { $detail })
told-gave-up = { $n } 回失敗したため中止: { $why }
told-gave-up-detail = { $n } 回失敗したため中止(詳細は英語: { $detail })
told-build-gave-up-stopped = ビルド { $build } は { $attempts } 回試して中止: 毎回 nestd が終了しました
told-gave-up-stopped = { $attempts } 回試して中止: 毎回 nestd が終了しました
told-build-given-up = ビルド { $build } は中止: { $why }
told-is-given-up = 中止: { $why }
told-is-given-up-detail = 中止(詳細は英語: { $detail })
told-no-copy-has-place = 今の装置に入るものが 1 つもありません
told-no-copy-left = 中に残っているものがありません
told-the-build-failed = ビルドに失敗しました
told-build-the-build-failed = ビルド { $build } に失敗しました
told-proving = 書き出したビルドの検証: { $why }
told-not-proved = 書き出したビルドを検証できません({ $detail })
told-panicked = 異常終了({ $detail })
told-search-stopped = 探索は { $secs } 秒で止められ、見つけたところから続けます
told-withdrawn-by = キューから取り下げ({ $by })
told-withdrawn-why = キューから取り下げ({ $by }): { $reason }
told-withdrawn-record = アーカイブの記録によると、手つかずのままキューから取り下げられました
told-put-back-from-backup = 台帳がバックアップから戻されました
told-urgent-goes-with-it = 最優先のものも一緒に入ります
told-arrived-goes-with-it = 新しく届いたものも一緒に入ります
told-printer-is-down = プリンター { $printer } は使用停止中です
told-made-again = 作成し直し: { $why }
told-machine-changed = 検証後に装置が変わりました({ $detail })
told-staged-removed = 用意したファイルが削除されました
told-staged-other = 用意したファイルが検証済みのものではありません

## Copies that are not in the next build

told-left-open-build = { $who } の { $n } 個は、{ $others }を優先して準備中のビルドから外れました。{ $what }次のビルドでは先頭です。
told-left-open-build-alone = { $who } の { $n } 個は準備中のビルドから外れました。{ $what }次のビルドでは先頭です。
told-cannot-be-in-next = { $who } の { $n } 個は次のビルドに入りません: { $why }。{ $what }その次のビルドでは先頭です。
told-name-priority = { $file }(パーツ { $part }、優先度 { $priority })
told-other-parts = { $others }、ほか { $n } 件
told-it-is = これは
told-they-are = これらは
told-no-room-beside = 優先される { $others } の隣に空きがありません
told-no-room-beside-copies = ほかの同じパーツの隣に空きがありません
told-no-place-found = 空の造形範囲に場所が見つかりません
told-whole-volume-first = 優先されるものだけでビルドがいっぱいです

## Refusals that people or orders caused

told-cancelled-by = { $by } がキャンセルしました。
told-line-cancelled = 受付前に明細がキャンセルされました。
told-newer-revision = 待機中に同名の新しい版(パーツ { $part })が届き、置き換わりました。両方必要な場合は、こちらを戻してください。
told-newer-revision-order = 待機中に、注文 { $order } の同名の新しい版(パーツ { $part })が届き、置き換わりました。両方必要な場合は、こちらを戻してください。
told-after-the-backup = エラーフォルダーにあります。バックアップの後に受付不可またはキャンセルになりました。
told-maybe-printed = キューのファイルに同じファイルが入っているため、造形済みの可能性があります。
told-taken-over-by-other = この nestd が応答しない間に、別の nestd がこのファイルを引き継ぎ、造形します。
told-no-reason = 理由は示されていません

## What happened: parts and orders

told-trigger-flush = 今すぐ確定
told-trigger-full = 満杯
told-trigger-fill = 設定の高さに到達
told-trigger-copies = 設定の個数に到達
told-trigger-max-wait = 待ち時間の上限
told-trigger-due = 納期
told-trigger-at = 確定時刻
told-ledger-query-failed = 台帳への問い合わせに失敗しました({ $detail })
told-step-taking-in = 処理結果の取り込み
told-step-new-configuration = 新しい設定の取り込み(済むまで何も適用されません)
told-process-named = プロセス { $pid }({ $name })
told-another-process = 別のプロセス
told-put-back-in-time = ファイルの中で以前の状態に戻されました: 変更は { $count } 件ですが、この nestd は { $seen } 件を見ています
told-record-of-build = ビルドの記録による
told-imported-record = アーカイブの記録から取り込み
told-imported-from-build = ビルドの記録から取り込み
told-replaces-part-all = 以前の版(パーツ { $old })を、指定ごと置き換えます
told-replaces-refused = 却下されたパーツ { $old } の代わりです
told-replaces-refused-all = 却下されたパーツ { $old } の代わりで、その指定をすべて引き継ぎます
told-replaces-refused-terms = 却下されたパーツ { $old } の代わりで、個数以外の指定をすべて引き継ぎます
told-replaces-part-terms = 以前の版であるパーツ { $old } の代わりで、個数以外の指定をすべて引き継ぎます
told-replaces-part-date = 以前の版(パーツ { $old })を、納期とメモごと置き換えます
told-more-wanted-record = ビルドの記録により { $more } 個追加
told-published-after-backup = バックアップの後にビルドが発行されました
told-decided-since = バックアップの後に、受付不可、キャンセル、戻し、変更のいずれかが行われました。
told-decided-since-wanted = バックアップの後に、受付不可、キャンセル、戻し、変更のいずれかが行われ、その時は { $copies } 個が必要でした。
told-decided-since-one = バックアップの後に、受付不可、キャンセル、戻し、変更のいずれかが行われ、その時は 1 個が必要でした。
told-out-of-queue-said = キューから出た({ $by })
told-once-more-asked = ビルド { $build } の再発行({ $by })
told-requeue-word = 再発行
told-same-dropped-again = 同じファイルがもう一度入れられました
told-taken-back = 戻されました
told-taken-back-mend = 引き取りました。{ $name } がメッシュの補修を許可しました
told-other-mending = メッシュが最初の読み取りと同じように補修されません。`nestd confirm { $part }` で読み直して補修し直します。
told-told-at-break-out = 取り出し時に記録
told-no-copy-waits-any-more = 待機中のものはなくなりました
told-file-not-needed = ファイルはもう必要ありません
told-by-whom = { $by }
told-has-seen-to-it = { $by } が対応しました
told-copies-instead = { $before } 個から { $n } 個に変更
told-as-it-was-taken = 受付時のとおり { $n } 個
told-more-wanted-by = { $by } が { $more } 個追加
told-fewer-wanted-by = { $by } が { $fewer } 個減らしました
told-order-instead = 注文: { $old } から { $new } に変更
told-customer-instead = 顧客: { $old } から { $new } に変更
told-priority-instead = 優先度: { $old } から { $new } に変更
told-due-instead = 納期: { $old } から { $new } に変更
told-note-instead = メモ: { $old } から { $new } に変更
told-unit-instead = 単位: { $old } から { $new } に変更
told-moved-from-to = { $from } から { $to } へ
told-replaces-part = 以前の版(パーツ { $old })を置き換えます
told-part-took-its-place = 同名のパーツ { $new } に置き換わりました
told-clock-set = { $jump }。パーツの経過時間は保たれます
told-put-back-from-build = ビルド { $build } の { $n } 個を { $by } が待機に戻しました
told-not-wanted-again = ビルド { $build } の { $n } 個は再造形しない({ $by })
told-printed-well-after-all = ビルド { $build } の 1 個は良品でした
told-not-taken-printer-first = 取り下げできず: 先にプリンターがファイルを取りました
told-not-taken-not-proved = 取り下げできず: キューにあるのは検証済みのファイルではありません
told-not-taken-second = 取り下げできず: キューに { $places } としてあります
told-back-in-queue-of = { $printer } のキューに戻りました
told-lies-in-queue-again = ファイルが { $printer } のキューに戻っています
told-closed-order = { $by }: 注文 { $name } を{ $what }
told-closed-with = { $n } 個中 { $accepted } 個で完了扱いにしました
told-closed-without-it = { $by }: これを除いて注文を完了扱いにしました
told-step-done = { $by }: { $name } 完了
told-step-not-done = { $by }: { $name } 未完了
told-steps-open-again = 追加の造形があるため、仕上げの工程は未完了に戻りました

## Answers to what people say on pages

told-is-being-nested = ビルド { $build } を { $n } 個でネスティング中です
told-nothing-waits-in = { $machine } に待機中のものはありません
told-is-paused = { $machine } は一時停止中です
told-was-paused-already = { $machine } はすでに一時停止中です
told-runs-again = { $machine } を再開しました
told-was-not-paused = { $machine } は一時停止中ではありません
told-resume-first = { $machine } は一時停止中です。先に再開してください
told-no-printer-in-use = { $machine } のプリンターはすべて使用停止中です。`nestd printer { $printer } up` で使えるようにします
told-copies-cancelled = パーツ { $part } の { $n } 個をキャンセルしました
told-has-values-already = パーツ { $part } はすでにその値です
told-part-changed = パーツ { $part }: { $why }
told-part-moved = パーツ { $part } を { $machine } に移し、読み取り直します
told-parts-moved = パーツ { $parts } を { $machine } に移し、読み取り直します
told-part-is-for = パーツ { $part } はすでに { $machine } 用です
told-printed-as-it-is = パーツ { $part } をそのまま造形します
told-no-confirmation = パーツ { $part } は承認待ちではありません
told-part-mended = パーツ { $part } を読み直し、メッシュを補修します
told-nothing-to-mend = パーツ { $part } はメッシュが理由で拒否されたのではありません。`nestd retry { $part }` でそのまま読み直します
told-is-read-again = パーツ { $part } を読み取り直します
told-part-is-cancelled = パーツ { $part } をキャンセルしました
told-no-such-part = パーツ { $part } はありません
told-no-such-machine = 装置 { $machine } はありません
told-no-such-build = ビルド { $build } はありません
told-waits-for-its-file = パーツ { $part } はファイルを待っています。もう一度入れ、読み取られてから、もう一度指示してください
told-ticket-of-part-unread = パーツ { $part } のチケットを読み取れませんでした。直して、両方をもう一度入れてください
told-refused-already = パーツ { $part } はすでに受付不可またはキャンセル済みです。理由は `nestd show p{ $part }` で確認できます
told-built-already = パーツ { $part } は作成済みです。すべて発行済みのビルドに入っています
told-build-is-told = ビルド { $build }: { $what }。
told-build-stays-told = ビルド { $build } は記録済みの結果のままです: { $what }。
told-issued-once-more = ビルド { $build } をビルド { $new } として再発行します。
told-is-released = ビルド { $build } は承認され、キューに入ります。
told-was-released-before = ビルド { $build } は承認済みです。
told-failure-dismissed = 失敗したビルド { $build } の造形を対応済みにしました。個々の状態は変わりません。
told-second-dismissed = ビルド { $build } の 2 つ目のファイルを対応済みにしました。今キューにあるものが唯一のファイルです。
told-now-down = プリンター { $printer } を使用停止にしました。ビルドは割り当てられません。
told-takes-again = プリンター { $printer } を再び使用します。
told-was-not-down = プリンター { $printer } は使用停止中ではありません。
told-taken-back-unless = プリンターが先に取らない限り、ビルド { $build } を { $printer } のキューから取り下げます。結果はビルドのページに出ます。
told-noted-taken-first = 承りました。ビルド { $build } のファイルを先に { $printer } のキューから取り出し、その後に実行します。
told-wait-again = { $parts } 件のパーツの { $n } 個が、指定はそのままで、先頭で再び{ $what }。
told-waits = 待機します
told-wait = 待機します
told-order-is-closed = 注文 { $name } を{ $what }。

## What a command or a form is refused for

told-other-state = ビルド { $build } は{ $what }で、{ $rest }ではありません
told-word-open = 準備中
told-word-nesting = ネスティング中
told-word-verified = 検証済み
told-word-claimed = 読み取り中
told-word-waiting = 待機中
told-word-batched = 作成中
told-word-built = ビルド済み
told-word-refused = 受付不可
told-or-words = { $what }または{ $rest }
told-made-again-since = ビルド { $build } はその後作り直されました。今の内容を確認してください
told-not-released-made-again = ビルド { $build } は承認されていません。作成し直します({ $detail })
told-file-not-in-queue = ビルド { $build } のファイルはキューにありません。プリンターが取ったか、別のプリンターに移動中です
told-in-build-as-it-is = パーツ { $part } はビルド { $build }({ $what })に入っており、そのまま造形されます。発行されてから、まだ待機中の分をもう一度指示してください。造形済みの分は `nestd reprint { $part }=N` で再造形します
told-only-refused-retried = パーツ { $part } は{ $what }です。戻せるのは受付不可かキャンセル済みのパーツだけです
told-outcome-recorded = ビルド { $build } の結果は記録済みです({ $what })。間違っている場合は `nestd outcome { $build } { $asked } --correct` を実行してください
told-outcome-the-same = ビルド { $build } の結果は同じ内容で記録済みです({ $what })。何も変更していません
told-outcome-the-same-bad = ビルド { $build } の結果は同じ内容で記録済みです({ $what })。何も変更していません。ほかのコピーが不良の場合は `nestd outcome { $build } { $asked } --correct --bad PART=N` を実行してください
told-was-taken-back-untouched = ビルド { $build } のファイルは手つかずでキューから取り下げられました。造形済みとは数えず、作り直します。それでも造形した場合は、待機中から同じ数を `nestd cancel PART=N` で除いてください。時刻とパーツは `nestd show b{ $build }` に出ます
told-none-counts-as-printed = 造形済みのものがありません。待機中の分は `nestd show`、追加は `nestd edit PART --copies N`
told-copies-being-cancelled = パーツ { $part } の一部をキャンセル中で、ビルドはその後に始まります
told-can-be-cancelled = パーツ { $part } でキャンセルできるのは { $asked } 個ではなく { $n } 個です。ほかはビルドに入っています(`nestd show p{ $part }`)
told-only-what-waits = パーツ { $part } は{ $what }です。変更できるのは待機中のものだけです。{ $remedy }
told-retry-first = 先に `nestd retry { $part }` で戻してください
told-edit-orders-more = 追加は `nestd edit { $part } --copies N`
told-lies-untouched = ビルド { $build } のファイルは { $printer } のキューに手つかずで残っており、造形されていないように見えます。番号が正しいか確認してください。正しければ強行してください({ $insist })。2 回造形されないよう、先にファイルをキューから取り出します
told-lies-untouched-untold = ビルド { $build } のファイルはキューに手つかずで残っており、結果も記録されていません。造形していない場合は `nestd withdraw { $build }` で取り下げ、造形した場合は先に `nestd outcome { $build } complete --bad PART=N` で不良の数とともに結果を記録してください
told-second-unseen = ビルド { $build } の 2 つ目のファイルがキューにありましたが({ $places })、nestd は今そこを確認できません。ご自身で確認し、そこにあれば取り出してください。誰も造形していなければ `nestd dismiss b{ $build }` の後、もう一度伝えてください
told-second-gone = ビルド { $build } の 2 つ目のファイルがキューにありましたが({ $places })、なくなっています。それを造形中または造形済みなら、{ $printer } のキューからファイルを取り出して、もう一度伝えてください。誰も造形していなければ `nestd dismiss b{ $build }` の後、もう一度伝えてください
told-lies-other-file = { $printer } のキューにビルド { $build } として置かれているのは、検証済みのファイルではありません。取り出し、造形されたか確かめて、もう一度指示してください
told-on-its-way = ビルド { $build } のファイルは別のプリンターに移動中です。着いてから、もう一度指示してください
told-being-taken-back = ビルド { $build } のファイルを取り下げ中です。結果は `nestd show b{ $build }` で確認できます
told-no-such-order = 注文 { $name } はありません。一覧は `nestd orders --all`
told-nothing-to-close = 注文 { $name } には待機中も受付不可もないため、完了扱いにするものがありません。結果は `nestd show order { $name }`
told-order-being-read = 注文 { $name } のファイルを受付・読み取り中です。少し待ってから完了扱いにしてください
told-printer-fallback-waits = { $machine } のビルドは、プリンターが使えるようになるまで待機します。
told-not-taken-goes-to = まだ取っていないものは { $printer } に移ります。
told-copies-cancelled-of-order = 待機中の { $n } 個をキャンセルしました。
told-copies-not-asked = 受付不可の { $n } 個はもう求めません。
told-to-be-taken-out = ビルド { $build } は再造形のためキューから取り下げるところでしたが、{ $why }。何も変更していません。{ $remedy }
told-lies-under-its-name = その名前でキューにあるのは検証済みのファイルではありません
told-copies-lie-as = キューに { $places } としてあります
told-printer-took-first = 先にプリンターが取りました
told-lies-elsewhere = 発行した場所ではなく { $place } にあります
told-take-out-look-say = 取り出し、造形されたか確かめて、もう一度指示してください
told-take-out-say = 取り出して、もう一度指示してください
told-say-when-known = 造形の結果がわかってから、もう一度指示してください
told-say-once-more = もう一度指示してください
told-published-in-no-queue = ビルド { $build } は取り下げられません。発行先のキューフォルダーがどのプリンターのものでもなくなっています。造形しない場合は `nestd outcome { $build } failed` で待機に戻せます
told-configuration-nothing = 何も適用されません({ $detail })
told-no-answer-in-time = 時間内に応答がありませんでした
told-no-finishing-steps = 部品 { $part } には仕上げの工程がありません。`nestd edit { $part } --finish '{ $name }'` でこの工程を付けられます
told-no-such-step = 部品 { $part } に仕上げの工程「{ $name }」はありません。あるのは { $names } です
told-step-not-printed = 部品 { $part } はまだ 1 個も造形されていないため、「{ $name }」を完了にできません

## Why a due date is at risk

risk-passed = 納期をすでに過ぎています
risk-too-long = 造形に時間がかかり、間に合いません
risk-left-out = 優先分が先に入り、次のビルドに場所がありません
risk-awaits-fire = ビルドの確定は { $time } 以降です
risk-printers-busy = プリンターは { $time } まで使用中です
risk-no-begin = 造形を開始するプリンターがありません
risk-printer-closed = プリンターは { $time } まで造形を開始しません
risk-awaits-release = ビルドが承認待ちです
risk-awaits-answer = 確認事項への回答待ちです
risk-awaits-material = 材料が装置に入っていません
risk-file-missing = ファイルが破損しているか、取り寄せ中です
risk-not-read = ファイルがまだ読み取られていません
risk-paused = 装置が一時停止中です
risk-unavailable = 装置が利用不可です
risk-no-printer = 装置に使用中のプリンターがありません
told-at-risk-one = { $name } の納期は { $due } です: { $why }
told-at-risk-one-of = { $names } の { $name } の納期は { $due } です: { $why }
told-at-risk = { $names } の納期は { $due } です: { $why }
told-at-risk-of = { $name } の { $names } の納期は { $due } です: { $why }
told-at-risk-more = { $names } ほか { $more } 件の納期は { $due } です: { $why }
told-at-risk-more-of = { $name } の { $names } ほか { $more } 件の納期は { $due } です: { $why }
told-machine-not-configured = 装置が設定されていません

## What is loaded

told-loaded-before = { $material } は以前から { $machine } に入っています
told-nothing-loaded-before = { $machine } には以前から何も入っていません
told-loaded-now = { $material } が { $machine } に入りました。次のビルドはこの材料になります
told-nothing-loaded-now = { $machine } には今何も入っていません。材料の指定があるパーツは待ちます
told-others-wait = そこの { $parts } 個のパーツは別の材料を待っています。材料は `nestd status` でわかります
told-fired-of-other = ビルド { $build } は先に開始され、材料は { $material } です。先に造形するか、取り下げてください
told-material-not-named = nestd.toml の [materials] に「{ $material }」はなく、{ $names } だけがあります。この中から選ぶか、追加して nestd を再読み込みしてください
told-no-machine-here = ここに装置「{ $machine }」はありません
told-part-not-loaded = パーツ { $part } の材料 { $material } は { $machine } に入っていません。入れたことの記録は `nestd machine load { $machine } '{ $material }'`
