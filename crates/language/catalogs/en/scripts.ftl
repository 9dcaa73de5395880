script-lost = No connection to the farm since { $time }. What is shown is from before.
script-changed = Something else stands in this build now.
script-load-again = Load the 3D view again
script-too-large = { $name } is larger than this farm takes ({ $size }).
script-sent-of = { $sent } of { $all } sent
script-sent = Sent; the farm writes it down.
script-answers = The farm answers { $status }.
script-connection-lost = The connection was lost. Send it again: what was added is not added twice.
script-which-machine = Which machine?
script-asking = asking when they could be done
script-no-answer = no answer
script-done = done about { $time }
script-no-date-known = no date known
script-adds = { $done }, adds { $height } mm
script-one-late = a date would be late
script-several-late = { $count } dates would be late
script-copied = Copied
script-no-view-script = No 3D view: its script did not arrive.
script-no-view = No 3D view: { $why }.
script-last-out = last out
script-first-out = first out
script-no-proved-order = no proved order of removal
script-what-has-no-order = what has no order
script-part-not-here = a part that is not here
script-chosen =
    Chosen: { $what }, { $count ->
        [one] { $count } copy
       *[other] { $count } copies
    }. "Show all" ends this.
script-show-all = Show all
script-layer = { $height } mm, layer { $layer } of { $layers }
script-copy-from-to = copy { $copy }, from { $low } to { $top } mm
script-step = step { $step } of removal
script-simplified = (drawn simplified)
script-missing =
    { $missing } of { $count ->
        [one] { $count } copy is
       *[other] { $count } copies are
    } not shown: the originals are no longer kept.
script-front = FRONT
script-soonest = soonest
