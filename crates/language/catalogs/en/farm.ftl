why-below = It is said below why
number-of = { $number } of { $all }
figure-print = printers print
figure-wait =
    { $count ->
        [one] copy waits
       *[other] copies wait
    }
figure-late =
    { $count ->
        [one] date late
       *[other] dates late
    }
figure-tight =
    { $count ->
        [one] date tight
       *[other] dates tight
    }
risks = Late, or at risk to be
more-dates =
    { $count ->
        [one] { $count } more date
       *[other] { $count } more dates
    }
due-done = due { $due }, done about { $done }
due-on = due { $due }
board = Board
legend-solid = is printed
legend-outlined = is made, or lies in the queue
legend-dashed = is to come, if nothing more arrives
legend-cool = cools
legend-closed = no print begins
no-machine-text = A machine is a file of a few lines: its volume, its clearance, its printers. { $command } writes it.
no-machine = No machine is configured on this node
no-machine-help = How to add a machine
nothing-came-drop = Drop { $formats } files on a machine below, or copy them into its hot folder. The farm collects them, nests them as low as it can and puts the build into the printer's queue.
nothing-came-copy = Drop { $formats } files into its hot folder. The farm collects them, nests them as low as it can and puts the build into the printer's queue.
nothing-came-help = How parts come in
nothing-came = Nothing has come yet
machine-of-node =
    The machine { $machine } is served by the node { $node }: { $parts ->
        [one] { $parts } part waits
       *[other] { $parts } parts wait
    }.
machine-is-gone =
    The machine { $machine } is no longer configured: { $parts ->
        [one] { $parts } part waits
       *[other] { $parts } parts wait
    }.
nodes-running =
    { $count ->
        [one] { $count } node
       *[other] { $count } nodes
    }, { $running } running
nodes = Nodes
daemon-silent = The daemon runs on { $host }, but has not written into the ledger for { $age }: this page may be that old. { $why }.
daemon-runs = The daemon runs on { $host } since { $time }: { $activity }.
daemon-dead = The daemon does not run; its last sign of life was { $age } ago.
daemon-never-ran = The daemon has not run yet.
build-word = Build
next-build = Next
dates-kept = dates kept
dates-not-known = when it is done is not known yet
about-mm = about { $height } mm
since-time = since { $time }
until-time = until { $time }
fires-begins = fires { $fires }, begins { $begins }
begins-time = begins { $time }
no-time-known = no time known yet
build-on = Build { $build } on { $printer }
build-number = Build { $build }
build-to-come-on = A build to come on { $printer }
build-to-come = A build to come
all-dates-kept = its due dates are kept
a-date-is-tight = a due date is tight
a-date-is-late = a due date is late
began-time = began { $time }
fires-time = fires { $time }
printed-time = print ends { $time }
unpacked-time = to be unpacked { $time }
add-files-here = Add files{ $unseen }{ $soft }
unseen-to = to { $machine }
or-drop-here = , or drop them here
unseen-of = of { $name }
free-time = Free { $time }
flush = Flush
unseen-flush = { $machine }: see what would be built now
pause = Pause
material-loaded = { $material } is loaded
load-text = The next build is made of what is loaded. Parts of another material wait. Leave it empty if nothing is loaded.
load = Say what is loaded
printer-down-text = A printer that is out of use takes no builds. What it has not taken goes to another printer of the machine, if there is one.
printer-down-do = Take the printer out of use
printer-up-do = Put it into use again
printer-named = printer { $printer }
resume = Resume
say-yes = Say yes to build { $build }
tell-how = Result of build { $build }
builds-of = Builds of { $name }
later-builds-of = Later builds of { $name }
nothing-waits = Nothing waits.
waiting-due =
    Waiting: { $copies } of { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    }, the first due { $due }
waiting =
    Waiting: { $copies } of { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    }
it-waits = It waits: { $why }
open-build = Open build { $build }:
height-of = { $height } of { $limit } mm
so-dense = { $density } dense
usual-density = (usual: { $density })
height-used = Height used by the open build of { $machine }: { $share } %
made-searched =
    Build { $build } is searched: { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
made-awaits =
    Build { $build } is proved and waits for a yes: { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
made-proved =
    Build { $build } is proved and goes to the queue: { $copies ->
        [one] { $copies } copy
       *[other] { $copies } copies
    }
spent-of = { $spent } of { $limit } s
search-for = Search for build { $build }
last-published = Last published: build { $build }
now = now
fires-if = Fires { $time } if nothing more arrives: { $why }.
fires-at-time = Fires { $time }: { $why }.
paused-by = Paused by { $by } since { $time }: nothing is fired.
unavailable-since = Unavailable, since { $time }: { $trouble }
unavailable-for = Unavailable: { $trouble }
needs = Needs a person
things-need =
    { $count ->
        [one] { $count } thing needs a person
       *[other] { $count } things need a person
    }
more-things =
    { $count ->
        [one] { $count } more thing
       *[other] { $count } more things
    }
since-sentence = Since { $time }.
what-to-do = What to do
its-queue = its queue folder
its-inbox = its hot folder
its-errors = its error folder
its-archive = its archive
failed-builds = Failed builds
print-as-is = Print as it is
cancel = Cancel the part
add-files = Add files
parts-that-wait = The parts that wait
order-of = order { $order }
read-again = Read it again
mend-and-print = Mend and print
all-refused = All refused
seen-to = Seen to
unseen-seen-to = : leave them there ({ $machine })
how-many = How many copies are wanted? They are taken as 1.
say-how-many = Say how many
machine-named = machine { $machine }
node-of-machine-gone = { $machine } is served by the node { $node }, which does not run. Nothing was done: start it, and send this again.
node-does-not-answer = the node { $node } has not answered: { $why }. Send this again when it answers: what it did already, it does not do twice
machine-just-moves = { $machine } is being given to another node: send this again in a moment
nodes-are-busy = many requests wait for other nodes just now: try again in a moment
