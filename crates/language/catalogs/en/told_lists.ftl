### Sentences about tickets, order lists and names, as they are stored in English.

## What a part waits for

told-waits-because = { $name } waits, because { $why }
told-stands-beside = { $name } stands beside { $why }
told-list-cannot-be-read = { $name } cannot be read: { $why }
told-list-not-understood = { $name } is not understood: { $why }
told-list-not-understood-detail = { $name } is not understood: { $detail }
told-list-above-not-understood = { $name } in a folder above is not understood
told-list-above-names-it = { $name } in a folder above names it, but a list is for the files of its own folder
told-list-aside-names-it = { $name } in another folder of the order names it, but a list is for the files of its own folder and below
told-list-above-not-read = { $name } in a folder above is a list that nestd does not read
told-in-no-row = { $name } stands in none of the { $rows } rows of { $list }
told-below-in-no-row = { $name } stands in none of the { $rows } rows of { $list } in a folder above
told-beside-list-not-understood = { $name } stands beside { $list }, which is not understood: { $why }
told-beside-list-detail = { $name } stands beside { $list }, which is not understood: { $detail }
told-came-after-row = { $name } came after its row in { $list } was used for a part of that name that had been taken before
told-not-clear-in-list = { $name } is not clear in { $list }: { $why }
told-rows-add-up = { $rows } rows are for { $name }; where all are wanted, add them up or give each its own file name or folder, otherwise leave one
told-row-may-be-for = its row { $row } may be for { $name } or for { $other }; write the whole name
told-row-folder = its row { $row } may be for { $name } or for { $other }; write its folder too, as here
told-ticket-not-read = { $name } is not read: a ticket is named like the whole part file with .toml added
told-ticket-for-several = { $name } may be for several parts: name it like the whole part file with .toml added
told-list-which = { $name }, which { $why }
told-is-hidden = is hidden, so nestd does not read it: take away the dot at the start of its name, or delete it
told-is-hard-link = is a hard link (it has another name elsewhere) and not everyone may read it, so nestd neither reads it nor prints parts according to it: drop a copy of the file
told-hard-link = { $name } is a hard link (it has another name elsewhere) and not everyone may read it, so nestd neither reads it nor prints parts according to it: drop a copy of the file
told-unreadable-list = { $name } { $what }. Drop it together with the parts that were refused because of it.
told-is-no-file = is { $what }, so nestd does not read it: put the file itself in its place
told-a-symbolic-link = a symbolic link
told-a-folder = a folder
told-a-socket = a socket
told-a-named-pipe = a named pipe
told-a-device = a device
told-a-spreadsheet = a spreadsheet
told-a-foreign-list = a list of another program
told-a-document = a document
told-sheet-not-read = { $file }, { $what }, which nestd does not read: save it as XLSX or CSV
told-document-not-read = { $file }, { $what }, which nestd does not read: write the files and their numbers into a list (CSV or XLSX) in its place
told-one-list = { $names }: put all rows into one list

## What files wait, or came too late

told-ticket-names-missing = { $list } names { $names }, which is not there
told-ticket-names-missing-all = { $list } names { $names }, which are not there
told-ticket-for-missing = { $ticket } is for { $names }, which is not there
told-ticket-for-missing-all = { $ticket } is for { $names }, which are not there
told-list-names-refused = { $list } names { $names }, which was refused: drop it again
told-list-names-refused-all = { $list } names { $names }, which were refused: drop them again
told-list-names-in-build = { $list } names { $names }, which is in a build already: where no other file of that name is to be printed, remove what is said here (`nestd edit` orders more copies)
told-list-names-in-builds = { $list } names { $names }, which are in builds already: where no other files of these names are to be printed, remove what is said here (`nestd edit` orders more copies)
told-late-several = It came after its part was taken, and it may mean several parts: { $others }. Change the one that is meant with `nestd edit PART`.
told-late-too-late =
    It came too late: { $name } is in build { $build } with { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    }. { $remedy }
told-late-published =
    It came too late: { $name } is in build { $build }, published { $time } with { $n ->
        [one] { $n } copy
       *[other] { $n } copies
    }. { $remedy }
told-late-order-more = Order { $more } more with `nestd edit { $part } --copies { $wanted }`.
told-late-fewer = It asks for fewer: while the build lies in the queue, `nestd withdraw { $build }` takes it back, and then `nestd edit { $part } --copies { $wanted }` changes it.
told-late-drop-both = What differs can be ordered again: drop { $name } together with this ticket, which prints it once more.
told-late-refused = It came after its part was taken: { $why }
told-late-no-date = Its due date is none here: { $detail }

## Why a ticket or a list cannot be used

told-ticket-broken = the ticket { $file } cannot be read: { $why }
told-ticket-broken-detail = the ticket { $file } cannot be read: { $detail }
told-two-tickets = there are two tickets for one part, { $first } and { $second }; leave one
told-unchanged-for = { $why }, and that did not change for { $secs } s
told-copies-unknown-list = { $why }. It is not certain what is asked with it, so it is not printed: drop it again together with a list that has a row for it, or with a ticket of its own.
told-copies-unknown-ticket = { $why }. It is not certain what is asked with it, so it is not printed: mend the ticket and drop both again.
told-blocked-by-file = Beside it stood a file that may say how it is wanted: { $why }. That did not change for { $secs } s, so { $name } was not taken without it. Mend that file and drop both again; where it says nothing of the part, drop the part alone.
told-list-unreadable = This order list cannot be read: { $why }. Correct it and drop it again together with its files.
told-list-no-files = This order list names no files.
told-list-missing-files = No file came within { $secs } s for { $missing } of { $rows } rows of this order list: { $names }.
told-other-rows-served = The other rows were served.
told-list-drop-missing = Drop these files together with a list for them.
told-list-drop-into-order = Drop these files into { $order }: each is taken as its row says.
told-file-never-came = { $list } names this file, which did not come.
told-drop-missing-file = Drop it into the folder of its order: it is taken as { $list } says.
told-place-taken = Part { $part } of the same name took its place.
told-cancel-missing-file = Where it is not wanted, `nestd cancel` with the number of this part takes it out.
told-file-and-row-missing = { $list } names this file, which did not come, and its row cannot be used: { $why }.
told-drop-with-copies = Drop the file together with a list that says how many copies are wanted.
told-ticket-without-part = This is a ticket for a part { $name }, but { $why }. Drop the part and the ticket together, the ticket named like the whole part file with .toml or .json added.
told-no-such-part-came = no such part came within { $secs } s
told-several-parts-called = several parts were called { $name }, so it was used for none of them
told-file-with-permissions = nestd cannot read this file: { $why }. Drop it again with permissions that let nestd read it.
told-this-is-symlink = This is a symbolic link; nestd does not follow links. Drop the file itself.
told-this-is-folder = This is a folder with the name of a part, a ticket or an order list, or one that lies too deep. A folder is an order: give it another name and drop it right into the hot folder.
told-this-is-socket = This is a socket, not a file. Drop the file of the part.
told-this-is-pipe = This is a named pipe, not a file. Drop the file of the part.
told-this-is-device = This is a device, not a file. Drop the file of the part.
told-one-order-list = A folder has one order list, but in this one there were { $names }: put all rows into one list. Drop that list together with the parts that were refused.
told-this-is-not-read = This is { $what }, which nestd does not read. Save it as XLSX or CSV, and drop that together with the parts.
told-this-is-document = This is a document that may say how many are wanted, and nestd does not read it. Write the files and their numbers into a list (CSV or XLSX), and drop that together with the parts.
told-this-is-surplus = This is { $what }, which nestd does not read; the parts beside it go by { $list }. Nothing needs to be done, unless it says something else: then save it as CSV under that name.
told-workbook-beside-list = This is a workbook beside the list { $list }, which the parts go by. Nothing needs to be done, unless the workbook says something else: then drop one of the two.
told-second-order-csv = This folder has another order.csv, in other upper or lower case. Put all rows into one list.
told-control-in-order = { $name } has the name of a control file, but lies in an order folder. A control file is for the whole machine: put an empty file { $file } right into the hot folder.
told-control-not-empty = { $name } has the name of a control file, but is not empty ({ $bytes } bytes), so nothing was done. Put an empty file of that name into the hot folder.
told-longer-than = it is longer than { $bytes } bytes
told-no-utf8 = it is not UTF-8 text
told-copies-range = copies = { $copies }; it must be 1 to { $most }
told-priority-range = priority = { $priority }; it must be 0 to { $most }
told-clearance-range = clearance_mm = { $clearance }; it must be 0 to { $most }
told-whole-number = { $word } = { $value }; it must be a whole number such as 10
told-a-number = { $word } = { $value }; it must be a number such as 2.5
told-no-quotes = { $word } = { $value } is text; write it without the quotes: { $word } = { $number }
told-number-without-quotes = { $word } = { $value }; it must be a number without quotes, such as 10
told-date-format = due = { $value }; it must be a date such as 2026-11-25 or a time such as 2026-11-25T17:00:00Z
told-date-years = due = { $value }; it must be a date such as 2026-11-25 or a time such as 2026-11-25T17:00:00Z, in the years { $first } to { $last }
told-no-whole-number = { $word } = { $value } is no whole number
told-no-number = { $word } = { $value } is no number
told-unit-word = unit = { $value }; it must be micron, mm, cm, inch, foot or m
told-date-of-list = due = { $value }; it must be a date such as 2026-11-25 or 25.11.2026, perhaps with a time such as 17:00
told-two-dates = due = { $value }, which may be two dates; write it as 2026-11-25
told-row-of = in the row of { $name }: { $why }
told-row-of-detail = in the row of { $name }: { $detail }
told-row-cells = it has { $cells } cells for { $columns } columns
told-row-path = it names a path; a list is for the files of its own folder
told-row-empty = its row is empty
told-sheets-empty = its sheets are empty
told-two-columns = it has two columns for { $column }
told-no-columns = none of its lines names its columns, at least file and copies; known are { $columns }, and their words in other languages
told-workbook-locked = it has a password, or is of an old kind; save it without a password as XLSX, or as CSV
told-workbook-damaged = as a workbook it is damaged: { $detail }
told-list-cannot-be-split = the list cannot be split into rows; save it again as UTF-8, with a header and commas

## Warnings and questions about a part

told-taken-without-list = It was taken without its order list: { $why }.
told-column-ignored = The column { $name } of its order list is unknown to nestd and was ignored.
told-columns-ignored = The columns { $names } of its order list are unknown to nestd and were ignored.
told-line-above-not-read = The line { $line } above the table of its order list was not read.
told-priorities-low = The highest priority of its order list is { $priority }, of 100 for the most urgent part: that is below the 50 of a part without a priority. Change the part with `nestd edit PART --priority N` where it is more urgent.
told-copies-question = How many copies? Taken as 1 copy, because { $why }. A ticket with `copies = N` says it.
told-copies-taken = Taken as 1 copy, because { $why }. A ticket with `copies = N` says it.
told-print-question = Is it to be printed? It waits for a yes, because { $why }.
told-row-without-copies = its row in { $list } names no number of copies
told-in-folder-called = it lies in a folder called { $name }
told-name-says = its name says { $words }
told-row-says = its row in { $list } says { $words }
told-name-unclear = its name says { $words }, which is no clear number of copies from 1 to { $most }
told-name-many = its name says { $words }, which is more than a name alone may order
told-name-no-utf8 = its name is not text in UTF-8, so a number in it cannot be read
told-name-of-part = { $file } (part { $part })
told-sync-conflict-part = its name says that a sync program found two versions of { $who }
told-sync-conflict = its name says that a sync program found two versions of { $name }
told-name-of-backup-part = its name is that of a backup of { $who }
told-name-of-backup = its name is that of a backup of { $name }
told-name-of-copy-part = its name is that of a copy of { $who }
told-name-of-copy = its name is that of a copy of { $name }
told-copy-came-first-part = { $who } has the name of a copy of it
told-copy-came-first = { $name } has the name of a copy of it
told-other-format-part = it may be { $who } in another format
told-other-format = it may be { $name } in another format
told-put-back-by-sync = it has the folder, the name, the bytes and the time of part { $part }, so a sync program may have put back what was taken already
told-took-place = it took the place of the parts { $names }, and nothing says how many are wanted of it
told-moved-namesake = part { $part } of this name in its order was moved to { $machine }, and it may be a newer one
told-same-file-other-unit = The same file as part { $part }, but in another unit: it is a part of another size.
told-same-file-more = The same file as part { $part }: taken as more copies.
told-same-file-refused = It is the same file as part { $part }, and this machine takes no file twice. Where more copies are meant, set duplicates = "warn" in the profile { $machine }, reload nestd and take it back.
told-written-later = More was written into this file after it had been taken, so it was taken once more, whole. What was taken first is an earlier part of the same name: where both are there, cancel that one.
