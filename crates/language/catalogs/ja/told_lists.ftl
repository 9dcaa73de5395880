### Sentences about tickets, order lists and names, as they are stored in English.

## What a part waits for

told-waits-because = { $name } は待機中です: { $why }
told-stands-beside = { $name } と同じフォルダーにあるもの: { $why }
told-list-cannot-be-read = { $name } を読み取れません: { $why }
told-list-not-understood = { $name } の内容がわかりません: { $why }
told-list-not-understood-detail = { $name } の内容がわかりません(詳細は英語: { $detail })
told-list-above-not-understood = 上のフォルダーの { $name } の内容がわかりません
told-list-above-names-it = 上のフォルダーの { $name } に名前がありますが、リストは同じフォルダーのファイルだけに有効です
told-list-aside-names-it = 注文の別のフォルダーの { $name } に名前がありますが、リストは同じフォルダーとその下のファイルだけに有効です
told-list-above-not-read = 上のフォルダーの { $name } は nestd が読み取れないリストです
told-in-no-row = { $name } は { $list } の { $rows } 行のどこにもありません
told-below-in-no-row = { $name } は、上のフォルダーの { $list } の { $rows } 行のどこにもありません
told-beside-list-not-understood = { $name } と同じフォルダーの { $list } の内容がわかりません: { $why }
told-beside-list-detail = { $name } と同じフォルダーの { $list } の内容がわかりません(詳細は英語: { $detail })
told-came-after-row = { $name } が届く前に、{ $list } の行は先に受け付けた同名のパーツに使われました
told-not-clear-in-list = { $list } では { $name } がはっきりしません: { $why }
told-rows-add-up = { $name } の行が { $rows } 行あります。すべて必要なら合計するか、それぞれ別のファイル名かフォルダーにしてください。そうでなければ 1 行だけ残してください
told-row-may-be-for = 行 { $row } は { $name } とも { $other } とも読めます。名前をすべて書いてください
told-row-folder = 行 { $row } は { $name } とも { $other } とも読めます。このようにフォルダーも書いてください
told-ticket-not-read = { $name } は読み取られません。チケットの名前は、パーツのファイル名全体に .toml を付けたものです
told-ticket-for-several = { $name } は複数のパーツに当てはまります。パーツのファイル名全体に .toml を付けた名前にしてください
told-list-which = { $name }({ $why })
told-is-hidden = 隠しファイルなので読み取られません。名前の先頭の点を取るか、削除してください
told-is-hard-link = 誰でも読めるわけではないハードリンク(別の場所に別名があります)なので、読み取られず、造形にも使われません。ファイルのコピーを入れてください
told-hard-link = { $name } は誰でも読めるわけではないハードリンク(別の場所に別名があります)なので、読み取られず、造形にも使われません。ファイルのコピーを入れてください
told-unreadable-list = { $name } を読み取れません({ $what })。そのために受付不可になったパーツと一緒に入れてください。
told-is-no-file = { $what }なので読み取られません。ファイルそのものを置いてください
told-a-symbolic-link = シンボリックリンク
told-a-folder = フォルダー
told-a-socket = ソケット
told-a-named-pipe = 名前付きパイプ
told-a-device = デバイス
told-a-spreadsheet = 表計算ファイル
told-a-foreign-list = 別ソフトのリスト
told-a-document = 文書
told-sheet-not-read = { $file }({ $what })は nestd では読み取れません。XLSX か CSV で保存してください
told-document-not-read = { $file }({ $what })は nestd では読み取れません。代わりにファイルと個数をリスト(CSV か XLSX)に書いてください
told-one-list = { $names }。すべての行を 1 つのリストにまとめてください

## What files wait, or came too late

told-ticket-names-missing = { $list } に { $names } がありますが、ファイルがありません
told-ticket-names-missing-all = { $list } に { $names } がありますが、これらのファイルがありません
told-ticket-for-missing = { $ticket } は { $names } 用ですが、ファイルがありません
told-ticket-for-missing-all = { $ticket } は { $names } 用ですが、これらのファイルがありません
told-list-names-refused = { $list } にある { $names } は受付不可になりました。もう一度入れてください
told-list-names-refused-all = { $list } にある { $names } は受付不可になりました。もう一度入れてください
told-list-names-in-build = { $list } にある { $names } はすでにビルドに入っています。同名の別ファイルを造形しない場合は、この記述を消してください(追加は `nestd edit`)
told-list-names-in-builds = { $list } にある { $names } はすでにビルドに入っています。同名の別ファイルを造形しない場合は、この記述を消してください(追加は `nestd edit`)
told-late-several = パーツの受付後に届き、複数のパーツに当てはまります: { $others }。対象のパーツを `nestd edit PART` で変更してください。
told-late-too-late = 遅すぎました: { $name } は { $n } 個がビルド { $build } に入っています。{ $remedy }
told-late-published = 遅すぎました: { $name } は { $n } 個が、{ $time } に発行されたビルド { $build } に入っています。{ $remedy }
told-late-order-more = あと { $more } 個は `nestd edit { $part } --copies { $wanted }` で追加してください。
told-late-fewer = より少ない数です。ビルドがキューにある間は `nestd withdraw { $build }` で取り戻し、`nestd edit { $part } --copies { $wanted }` で変更してください。
told-late-drop-both = 違う分は改めて注文できます。{ $name } をこのチケットと一緒に入れると、もう一度造形します。
told-late-refused = パーツの受付後に届きました: { $why }
told-late-no-date = 納期がここでは無効です({ $detail })

## Why a ticket or a list cannot be used

told-ticket-broken = チケット { $file } を読み取れません: { $why }
told-ticket-broken-detail = チケット { $file } を読み取れません(詳細は英語: { $detail })
told-two-tickets = 1 つのパーツにチケットが 2 つあります({ $first } と { $second })。1 つだけ残してください
told-unchanged-for = { $why }。{ $secs } 秒間そのままでした
told-copies-unknown-list = { $why }。注文の内容が確かでないため造形しません。行のあるリストか専用のチケットと一緒に、もう一度入れてください。
told-copies-unknown-ticket = { $why }。注文の内容が確かでないため造形しません。チケットを直し、両方をもう一度入れてください。
told-blocked-by-file = 横に指定が書かれている可能性のあるファイルがありました: { $why }。{ $secs } 秒間変わらなかったため、{ $name } だけを受け付けることはしませんでした。そのファイルを直し、両方をもう一度入れてください。パーツと関係がなければ、パーツだけを入れてください。
told-list-unreadable = この注文リストを読み取れません: { $why }。直して、ファイルと一緒にもう一度入れてください。
told-list-no-files = この注文リストにファイル名がありません。
told-list-missing-files = この注文リストの { $rows } 行のうち { $missing } 行のファイルが { $secs } 秒以内に届きませんでした: { $names }。
told-other-rows-served = ほかの行は済んでいます。
told-list-drop-missing = これらのファイルを、そのリストと一緒に入れてください。
told-list-drop-into-order = これらのファイルを { $order } に入れてください。それぞれ行に書かれたとおりに受け付けます。
told-file-never-came = { $list } にあるこのファイルが届いていません。
told-drop-missing-file = このファイルを注文のフォルダーに入れてください。{ $list } のとおりに受け付けます。
told-place-taken = 同じ名前のパーツ { $part } がこれに代わりました。
told-cancel-missing-file = 不要な場合は `nestd cancel` とこのパーツの番号で取り消します。
told-file-and-row-missing = { $list } にあるこのファイルが届いておらず、その行も使えません: { $why }。
told-drop-with-copies = このファイルを、必要な個数を書いたリストと一緒に入れてください。
told-ticket-without-part = これはパーツ { $name } のチケットですが、{ $why }。パーツとチケットを一緒に入れてください。チケットの名前は、パーツのファイル名全体に .toml か .json を付けたものです。
told-no-such-part-came = そのパーツが { $secs } 秒以内に届きませんでした
told-several-parts-called = { $name } という名前のパーツが複数あったため、どれにも使われませんでした
told-file-with-permissions = nestd はこのファイルを読み取れません: { $why }。nestd が読み取れる権限で、もう一度入れてください。
told-this-is-symlink = シンボリックリンクです。nestd はリンクをたどりません。ファイルそのものを入れてください。
told-this-is-folder = パーツ、チケット、注文リストの名前のフォルダーか、深すぎるフォルダーです。フォルダーは注文を表します。別の名前にして、ホットフォルダーの直下に入れてください。
told-this-is-socket = ファイルではなくソケットです。パーツのファイルを入れてください。
told-this-is-pipe = ファイルではなく名前付きパイプです。パーツのファイルを入れてください。
told-this-is-device = ファイルではなくデバイスです。パーツのファイルを入れてください。
told-one-order-list = フォルダーの注文リストは 1 つですが、{ $names } がありました。すべての行を 1 つのリストにまとめ、受付不可になったパーツと一緒に入れてください。
told-this-is-not-read = nestd では読み取れません({ $what })。XLSX か CSV で保存し、パーツと一緒に入れてください。
told-this-is-document = この文書には個数が書かれているかもしれませんが、nestd では読み取れません。ファイルと個数をリスト(CSV か XLSX)に書き、パーツと一緒に入れてください。
told-this-is-surplus = nestd では読み取れません({ $what })。同じフォルダーのパーツは { $list } に従います。内容が違う場合だけ、その名前の CSV で保存してください。
told-workbook-beside-list = パーツが従うリスト { $list } と同じフォルダーのブックです。内容が違う場合だけ、どちらか 1 つを入れてください。
told-second-order-csv = 大文字小文字の異なる order.csv がもう 1 つあります。すべての行を 1 つのリストにまとめてください。
told-control-in-order = { $name } は制御ファイルの名前ですが、注文フォルダーにあります。制御ファイルは装置全体に効きます。空のファイル { $file } をホットフォルダーの直下に置いてください。
told-control-not-empty = { $name } は制御ファイルの名前ですが、空ではない({ $bytes } バイト)ため、何もしませんでした。その名前の空のファイルをホットフォルダーに置いてください。
told-longer-than = { $bytes } バイトより長くなっています
told-no-utf8 = UTF-8 のテキストではありません
told-copies-range = copies = { $copies }。1 から { $most } までで指定してください
told-priority-range = priority = { $priority }。0 から { $most } までで指定してください
told-clearance-range = clearance_mm = { $clearance }。0 から { $most } までで指定してください
told-whole-number = { $word } = { $value }。10 のような整数にしてください
told-a-number = { $word } = { $value }。2.5 のような数にしてください
told-no-quotes = { $word } = { $value } は文字列です。引用符なしで { $word } = { $number } と書いてください
told-number-without-quotes = { $word } = { $value }。10 のように、引用符なしの数にしてください
told-date-format = due = { $value }。2026-11-25 のような日付か 2026-11-25T17:00:00Z のような時刻にしてください
told-date-years = due = { $value }。{ $first } 年から { $last } 年までの、2026-11-25 のような日付か 2026-11-25T17:00:00Z のような時刻にしてください
told-no-whole-number = { $word } = { $value } は整数ではありません
told-no-number = { $word } = { $value } は数ではありません
told-unit-word = unit = { $value }。micron、mm、cm、inch、foot、m のどれかにしてください
told-date-of-list = due = { $value }。2026-11-25 や 25.11.2026 のような日付にしてください。17:00 のような時刻も付けられます
told-two-dates = due = { $value } は 2 通りに読めます。2026-11-25 の形で書いてください
told-row-of = { $name } の行: { $why }
told-row-of-detail = { $name } の行(詳細は英語: { $detail })
told-row-cells = { $columns } 列に対してセルが { $cells } 個あります
told-row-path = パスが書かれています。リストは同じフォルダーのファイルだけに有効です
told-row-empty = 行が空です
told-sheets-empty = シートが空です
told-two-columns = { $column } の列が 2 つあります
told-no-columns = 列名の行がありません。少なくとも file と copies が必要です。使えるのは { $columns } と、ほかの言語でそれに当たる語です
told-workbook-locked = パスワード付きか古い形式です。パスワードなしの XLSX か CSV で保存してください
told-workbook-damaged = ブックとして破損しています({ $detail })
told-list-cannot-be-split = リストを行に分けられません。UTF-8 で、見出しとコンマ付きで保存し直してください

## Warnings and questions about a part

told-taken-without-list = 注文リストなしで受け付けました: { $why }。
told-column-ignored = 注文リストの列 { $name } は nestd が知らない列なので、無視しました。
told-columns-ignored = 注文リストの列 { $names } は nestd が知らない列なので、無視しました。
told-line-above-not-read = 注文リストの表の上の行 { $line } は読み取れませんでした。
told-priorities-low = 注文リストの最高の優先度は { $priority } です(最も急ぐパーツは 100)。優先度のないパーツの 50 より低くなっています。急ぐパーツは `nestd edit PART --priority N` で変えてください。
told-copies-question = 何個必要ですか? 1 個として受け付けました: { $why }。チケットに `copies = N` と書いて指定してください。
told-copies-taken = 1 個として受け付けました: { $why }。チケットに `copies = N` と書いて指定してください。
told-print-question = 造形しますか? 承認待ちです: { $why }。
told-row-without-copies = { $list } の行に個数がありません
told-in-folder-called = { $name } という名前のフォルダーにあります
told-name-says = 名前に { $words } とあります
told-row-says = { $list } の行に { $words } とあります
told-name-unclear = 名前に { $words } とありますが、1 から { $most } までの個数としてはっきりしません
told-name-many = 名前に { $words } とありますが、名前だけで注文できる個数を超えています
told-name-no-utf8 = 名前が UTF-8 ではないため、個数を読み取れません
told-name-of-part = { $file }(パーツ { $part })
told-sync-conflict-part = 同期ソフトが { $who } の 2 つの版を見つけたことが名前からわかります
told-sync-conflict = 同期ソフトが { $name } の 2 つの版を見つけたことが名前からわかります
told-name-of-backup-part = { $who } のバックアップの名前です
told-name-of-backup = { $name } のバックアップの名前です
told-name-of-copy-part = { $who } のコピーの名前です
told-name-of-copy = { $name } のコピーの名前です
told-copy-came-first-part = { $who } はこのファイルのコピーの名前です
told-copy-came-first = { $name } はこのファイルのコピーの名前です
told-other-format-part = 別の形式の { $who } かもしれません
told-other-format = 別の形式の { $name } かもしれません
told-put-back-by-sync = フォルダー、名前、内容、時刻がパーツ { $part } と同じです。受け付け済みのものを同期ソフトが戻した可能性があります
told-took-place = パーツ { $names } の代わりになりましたが、必要な個数がどこにも示されていません
told-moved-namesake = 同じ注文のこの名前のパーツ { $part } は { $machine } へ移されており、これはその新しい版かもしれません
told-same-file-other-unit = パーツ { $part } と同じファイルですが、単位が違うため、別のサイズのパーツです。
told-same-file-more = パーツ { $part } と同じファイルです。追加の個数として受け付けました。
told-same-file-refused = パーツ { $part } と同じファイルで、この装置は同じファイルを 2 回受け付けません。追加の個数であれば、プロファイル { $machine } で duplicates = "warn" を設定し、nestd を再読み込みして戻してください。
told-written-later = 受付後に書き足されたため、全体をもう一度受け付けました。先に受け付けたものは同名の以前のパーツです。両方ある場合は、以前のほうをキャンセルしてください。
