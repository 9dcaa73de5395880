break-out-steps = Break it out step by step
pick-map = Pick map
acts-print = Print
acts-unpack = Unpack
acts-again = Print again
nothing-in-it = Nothing stands in it yet.
figure-high = high, of { $volume }
figure-copies =
    { $count ->
        [one] copy
       *[other] copies
    }
figure-bad =
    { $count ->
        [one] bad copy
       *[other] bad copies
    }
figure-dense = dense
figure-unpacked = to be unpacked, as far as is known
what-became = What became of it
outcomes = Outcomes
file-build = Build file, { $format }
file-build-for = what the printer gets
file-report = Report, HTML
file-report-for = to mail: 3D view, facts and pick map in one file
file-picture = Picture, PNG
file-pick-csv = Pick map, CSV
file-pick-csv-for = for a spreadsheet
file-pick-json = Pick map, JSON
file-json = Build, JSON
file-json-for = all that is known of it
file-search = Report of the search, JSON
file-not-kept = Its build file is not kept here any more: its printer took it, or it was not made yet.
files = Files
build-file-of = build file of build { $build } on this node
search-report-of = report of the search for build { $build } on this node
flush-machine = Flush { $machine }?
nothing-to-build = Nothing waits for it: there is nothing to build.
in-no-layout =
    { $copies ->
        [one] { $copies } waiting copy stands in no layout yet.
       *[other] { $copies } waiting copies stand in no layout yet.
    } The final search tries to take them, too.
flush-now = Flush now
unseen-flush-now = { $machine }: publish what waits now
not-now = Not now
in-layout-so-far = In the layout so far
in-layout = In the layout
waiting-in-no-layout = Waiting, in no layout yet
flush-title = Flush { $machine }
copies-of-parts =
    { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    } of { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    }
they-wait = { $waiting } wait.
layout-stands-dense = The layout so far holds { $copies } of them and stands at { $height }, { $density } dense.
layout-stands = The layout so far holds { $copies } of them and stands at { $height }.
flush-text = A flush searches for { $secs } s, proves the build and puts it into the queue; it may come out lower. Copies that find no place go on waiting.
pick-map-of = Pick map of build { $build }
pick-forecast = A forecast: what stands where changes until the build is published. Not for breaking out.
made-by = Made by nestd { $version }. Lengths are mm.
parts-not-shown =
    { $parts ->
        [one] { $parts } part is
       *[other] { $parts } parts are
    } not shown: the originals are no longer kept.
seed = seed { $seed }
asked = { $clearance } asked
picture-of-cake = The build, seen from the front, a little from the right and from above
pick-axes = x from the left, y from the front, top and bottom from the floor.
pick-downwards = Copies that go down come out when the cake is lifted or turned.
listed-without-place =
    { $parts ->
        [one] { $parts } part is
       *[other] { $parts } parts are
    } listed without a place: the originals are no longer kept.
pick-sheet = Copies: { $title }
pick-done = Done
pick-proved-order = Each copy comes out on a straight line past all that are listed after it, as it was proved on the triangles; the way says whereto.
pick-height-order = By height, from the top down; whether each comes out past the others is not said here.
pick-from-to = { $first } to { $last }
pick-from-down = From { $height } mm down
pick-no-originals = Originals no longer kept
pick-plan = What they cover, from above, with their numbers
front = front
name-of-order = { $name } (order { $order })
picture-of-refused = The part as it was dropped; where its surface is not closed, the edges are red
picture-of-mended = The part as it is mended; the mended places are red
picture-of-part = The part as it was dropped
picture-so-far = so far
picture-published-last = published last
height-not-known = height not known yet
so-high = { $height } high
picture-of-build = Build { $build }, { $what }: { $copies }, { $height }
colour-part = part
colour-order = order
colour-due = due date
colour-height = height
colour-step = step of removal
view-3d = 3D view
view-needs-script = The 3D view needs JavaScript.
view-needs-script-report = The 3D view needs JavaScript; the pick map has a picture.
view-keys =
    Nest of { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }; arrow keys turn it, + and - zoom
view-hint = Point at a copy or at a line of the list to see what it is; press to keep it chosen.
parts-by-order = Parts by order
no-order = No order
colour-by = Colour by
layers-up-to = Layers up to
explode = Explode
whole-view = Whole view
event-taken = taken
fired-and-nested =
    { $trigger }, nested { $count ->
        [one] once
       *[other] { $count } times
    }
ago = { $age } ago
time-by = { $time } by { $by }
on-its-way-to = { $printer }, on its way to { $other }
bound-text = { $bound }: no build of these parts is lower
clearance-proved = { $clearance } proved on the triangles
clearance-no-two = proved: no two are near
clearance-once-fired = proved once it is fired
clearance-asked = { $asked } asked, { $proved }
evaluations =
    { $count ->
        [one] { $count } evaluation
       *[other] { $count } evaluations
    }
cpu-secs = { $secs } CPU s
wall-secs = { $secs } wall s
bytes-and-hash = { $bytes } bytes, BLAKE3 { $hash }
state-since = { $state } since { $time }
triangles = { $count } triangles
not-read-yet = not read yet
as-ticket-says = { $clearance }, as its ticket says
way-up = up
way-down = down
way-right = right
way-left = left
way-back = back
way-front = front
mended-text = { $what }; allowed by { $by }; mended mesh BLAKE3 { $hash }
