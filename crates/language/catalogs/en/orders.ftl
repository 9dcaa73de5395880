a-number-of-orders = a number of orders
a-state-of-order = a state of an order
order-named = order named '{ $order }'
first-orders =
    { $count ->
        [one] { $count } order
       *[other] { $count } orders
    }, the first of more
count-orders =
    { $count ->
        [one] { $count } order
       *[other] { $count } orders
    }
name-contains = Name contains
customer-contains = Customer contains
no-such-orders = No such orders
no-such-orders-text = Files in a folder of an order's name, or with a ticket or list that names one, are listed here.
all-orders = All orders
order-title = Order { $order }
send-to-customer = To send to the customer
copy-text = Copy
count-lines =
    { $count ->
        [one] { $count } line
       *[other] { $count } lines
    }
lines-arrive =
    { $count ->
        [one] { $count } line
       *[other] { $count } lines
    } more came by request and will be here in a moment.
where-copies-are = Where the copies are
copies-wait-for-build =
    { $count ->
        [one] { $count } copy waits
       *[other] { $count } copies wait
    } for a build.
order-in-no-build = No copy of it is in a build yet.
what-happened-who = What happened, and who did it
events = Events
order-for = For { $customer }.
order-since = { $copies }; since { $time }.
order-due = Due { $due }.
order-done = Done { $time }
order-expected = Expected { $time }
order-should-be-done = Should be done since { $time }
order-closed = Closed { $how }.
order-short-text = Not all of it is good, or will be: drop what was refused again, or accept the order as it is.
a-state-of-part = a state of a part
the-number-of-part = the number of a part
file-begins-with = File or order begins with
parts-text = Parts that are read, wait, are in a build that is being made, or were refused in the last 30 days. Ask for others by state or name.
next-parts = The parts before these
newest-parts =
    { $count ->
        [one] { $count } part
       *[other] { $count } parts
    }, the newest of more
no-parts = No parts.
part-title = Part { $part }: { $name }
part-of-order = Part of the order { $order }.
where-its-copies-are = Where its copies are
what-happened = What happened
same-file = The same file at other times
other-files = Other files of this name
part-number = Part { $part }
part-in-no-build = In no build: { $why }.
part-in-open-build =
    { $waiting ->
        [one] { $waiting } copy waits
       *[other] { $waiting } copies wait
    }; in the open build { $build } so far: { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }.
part-waits =
    { $waiting ->
        [one] { $waiting } copy waits
       *[other] { $waiting } copies wait
    }, in no build yet.
search-for-text = Search: { $text }
nothing-found = Nothing has this in its name.
search-help = Search for any part of the name of a part, file, order, customer, build or machine, in upper or lower case; of several words a name must contain each. A number finds the build and the part with it:
found-part = part { $part }, { $state } on { $machine }
found-orders = orders
found-customers = customers
count-customers =
    { $count ->
        [one] { $count } customer
       *[other] { $count } customers
    }
found-builds = builds
found-machines = machines
found-parts = parts
or-more = { $number } or more
more-not-shown = { $link }: { $what }, { $count } more.
show-more = Show more
closed-by =
    { $time } by { $by }, with { $accepted } of { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
no-copies = none
not-known = not known
not-known-taken-as-one = not known, taken as 1
copies-not-known = not known ({ $copies })
lines-without-number =
    { $lines ->
        [one] how many of { $lines } line is not known
       *[other] how many of { $lines } lines is not known
    }
waits-for-yes-to = Waits for a yes: { $question }
waits-for-material = Waits until { $material } is loaded on { $machine }
in-build-state = { $copies } in build { $build } ({ $state })
none-in-build = none in a build
and-more = and { $count } more
bad-copies-of = { $count } (no. { $numbers })
copies-good = { $count } good
copies-printed = { $count } should be printed
copies-printing = { $count } printing
copies-queued = { $count } in the queue
copies-in-build = { $count } in a build
copies-waiting = { $count } waiting
copies-refused = { $count } refused
copies-bad = { $count } bad
copies-withdrawn = { $count } withdrawn
copies-cancelled = { $count } cancelled
note-refused =
    { $parts ->
        [one] { $parts } part is not made
       *[other] { $parts } parts are not made
    }
note-one-not-printed = it is not printed yet
note-none-printed = none of the { $parts } parts is printed yet
note-one-printed = it is printed
note-all-printed = all { $parts } parts are printed
note-one-should = it should be printed by now
note-all-should = all { $parts } parts should be printed by now
note-some-should = { $printed } of { $parts } parts should be printed by now
note-some-printed =
    { $printed ->
        [one] { $printed } of { $parts } parts is printed
       *[other] { $printed } of { $parts } parts are printed
    }
note-complete = Your order { $order } is complete: { $printed }.
note-cancelled = Your order { $order } was cancelled.
note-closed =
    Your order { $order } is complete with { $accepted } of { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    }.
note-order = Your order { $order }: { $how }.
note-all-expected = all of it is expected { $day }
note-rest-expected = the rest is expected { $day }
note-all-made = all of it is in production
note-rest-made = the rest is in production
note-all-not-known = a date for them is not known yet
note-rest-not-known = a date for the rest is not known yet
note-sorry = We are sorry: it was due { $day }.
note-and-expected = { $how }, { $expected }
note-and-refused = { $how }; { $refused }
note-then-sorry = { $note } { $sorry }
finishing-done = Done: { $done } of { $steps }
finishing-by = done: { $who }, { $when }
finishing-open = not done yet
finishing-is-done = It is done
finishing-not-yet = Not done yet
