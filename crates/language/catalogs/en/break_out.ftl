bins = Bins
bin = Bin
bin-not-found = Not found
bin-in-cake = In the cake
break-out-title = Break out build { $build }
whole-pick-map = The whole pick map, to print
on-other-screens = On other screens
last-elsewhere =
    { $count ->
        [one] The last copy is on another screen
       *[other] The last { $count } copies are on other screens
    }
said-before = { $who } said so before, { $when }: { $word }. Is it another copy that you have in hand?
said-already = Said already
said-since = { $who } said since, { $when }, that this copy is { $word }. That stays. Look at the copy again to say otherwise.
not-recorded = Not recorded
no-copies-of-build = These are no copies of this build.
recorded-as =
    { $copies ->
        [one] { $copies } copy is
       *[other] { $copies } copies are
    } recorded as { $word }.
recorded-in-part = Recorded in part
copy-is-said-before = { $copy }, is { $word }, as { $who } said before. That stays.
nothing-to-undo-text = Somebody said something else of it since, or took it back already.
nothing-to-undo = Nothing to take back
told-of =
    { $told } of { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
break-out-counts = { $told }: { $good } good, { $bad } bad, { $missing } not found, { $open } in the cake.
copies-told = Copies of which something is said
copy-of-all = Copy { $number } of { $all }
bin-number = Bin { $number }
the-part = The part { $name }
chosen-copy = Chosen: number { $number }, { $name }, copy { $copy }.
comes-out-downwards = It comes out when the cake is lifted or turned.
looks-like = Looks like { $names }.
go-on-next = Go on with the next one
later-next = Later: show the next one
on-screen-of = It is on the screen of { $name }.
have-in-hand = I have it in hand
was-told-bad = It was told bad, and waits to be printed again.
copy-is-said = It is { $word }, as { $who } said, { $when }.
still-in-cake = It is still in the cake
press-out = Out
press-bad = Bad
press-missing = Not found
place-of-copy = Top at { $top } mm, { $x } mm from the left, { $y } mm from the front.
place-not-known = Its original is no longer kept: its place is not known.
way-out = Out: { $way }.
copy-number = Copy { $copy }.
still-in-cake-count =
    Still in the cake: { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
screen-of = on the screen of { $name }
all-out-good = All of these are out and good
none-found = None of these was found
told-bad = told bad
the-end = The end
cake-is-empty = The cake is empty
good-of-all =
    { $good } of { $copies ->
        [one] { $copies } copy is
       *[other] { $copies } copies are
    } good.
outcome-is-told = The outcome is told.
tell-some-again = Tell it: printed, and those copies again
tell-all-good = Tell it: printed, all good
bad-wait-again = Copies that are bad or were not found wait again, first in line, with all that was asked.
name-and-copy = { $name }, copy { $copy }
last-press-all = Last: { $copies } copies, { $word }, by { $who }, { $when }.
last-press = Last: { $number } { $name }, copy { $copy }, { $word }, by { $who }, { $when }.
undo-all = Undo all { $count }
copy-title = { $number }: { $name }, copy { $copy }
published-build = published build { $build }: it can be broken out once it is printed
bin-no-order = no order
mark-out = out
mark-bad = out and bad
mark-missing = not found
mark-open = still in the cake
step-plan = Where it stands, from above
all-of-part-out = All { $count } of this part here: out
all-of-order-out = All { $count } of this order here: out
all-without-order-out = All { $count } without an order here: out
your-name = Your name
that-is-me = That is me
who-works = Who works here? The name is asked once on this device.
you-are = You are { $name }.
somebody = somebody
