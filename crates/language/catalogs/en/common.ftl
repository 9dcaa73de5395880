### Words of all pages: counts, dates, times.

## Dates

# A day near today: Fri 4 Dec.
date-day = { $weekday } { $day } { $month }
# A day far from today: 4 Dec 2027.
date-year = { $day } { $month } { $year }
# October 2026.
date-month = { $month } { $year }
date-today = today
date-tomorrow = tomorrow
date-yesterday = yesterday
# $day is one of the above; $clock is 05:49.
date-clock = { $day } { $clock }
# A time that nobody told.
about-time = about { $time }
# On the axis of the board.
date-today-alone = Today
# In a sentence to a customer: Friday 4 December.
date-long = { $weekday } { $day } { $month }
date-long-year = { $weekday } { $day } { $month } { $year }
weekday-long =
    { $weekday ->
        [1] Monday
        [2] Tuesday
        [3] Wednesday
        [4] Thursday
        [5] Friday
        [6] Saturday
       *[7] Sunday
    }
weekday-short =
    { $weekday ->
        [1] Mon
        [2] Tue
        [3] Wed
        [4] Thu
        [5] Fri
        [6] Sat
       *[7] Sun
    }
month-short =
    { $month ->
        [1] Jan
        [2] Feb
        [3] Mar
        [4] Apr
        [5] May
        [6] Jun
        [7] Jul
        [8] Aug
        [9] Sep
        [10] Oct
        [11] Nov
       *[12] Dec
    }
month-long =
    { $month ->
        [1] January
        [2] February
        [3] March
        [4] April
        [5] May
        [6] June
        [7] July
        [8] August
        [9] September
        [10] October
        [11] November
       *[12] December
    }

## Durations

# $span is 3h 5m or 2d 2h, as it is written in all languages.
due-in = in { $span }
due-overdue = { $span } overdue
# $delay is 40 min, 28 h, 3 days.
late-by = { $delay } late
delay-min = { $minutes } min
delay-hours = { $hours } h
delay-days =
    { $days ->
        [one] { $days } day
       *[other] { $days } days
    }

## Counts

count-copies =
    { $count ->
        [one] { $count } copy
       *[other] { $count } copies
    }
count-parts =
    { $count ->
        [one] { $count } part
       *[other] { $count } parts
    }
count-files =
    { $count ->
        [one] { $count } file
       *[other] { $count } files
    }
count-builds =
    { $count ->
        [one] { $count } build
       *[other] { $count } builds
    }
count-more-builds =
    { $count ->
        [one] { $count } more build
       *[other] { $count } more builds
    }

## Labels of fields: headings of tables and of facts

field-build = Build
field-part = Part
field-machine = Machine
field-state = State
field-state-in-the-ledger = State in the ledger
field-time = Time
field-question = Question
field-reason = Reason
field-reason-or-warning = Reason or warning
field-note = Note
field-height = Height
field-machine-height = Machine height
field-bound = Bound
field-density = Density
field-mean-density = Mean density
field-used = Used
field-machine-time = Machine time
field-parts = Parts
field-cake = Cake
field-failed = Failed
field-powder = Powder
field-price = Price
field-currency = Currency
field-yield = Yield
field-layers = Layers
field-layer = Layer
field-copies = Copies
field-copies-here = Copies here
field-copies-waiting = Copies waiting
field-of = Of
field-lines = Lines
field-wanted = Wanted
field-in-builds = In builds
field-queued = Queued
field-printing = Printing
field-printed = Printed
field-good = Good
field-refused = Refused
field-bad = Bad
field-bad-copies = Bad copies
field-cancelled = Cancelled
field-builds = Builds
field-volume = Volume
field-clearance = Clearance
field-proved = Proved
field-cpu = CPU
field-wall-time = Wall time
field-evaluations = Evaluations
field-seed = Seed
field-method = Method
field-search = Search
field-repeats = Repeats
field-version = Version
field-fired-by = Fired by
field-opened = Opened
field-nesting = Nesting
field-verified = Verified
field-published = Published
field-file = File
field-file-or-reason = File or reason
field-content = Content
field-made = Made
field-name = Name
field-order = Order
field-e-mail = E-mail
field-customer = Customer
field-material = Material
field-finishing = Finishing
field-lot = Lot
field-loaded = Loaded
field-priority = Priority
field-due = Due
field-claimed = Claimed
field-orientation = Orientation
field-size = Size
field-warning = Warning
field-where = Where
field-origin-of-the-file-at = Origin of the file at
field-turned = Turned
field-break-out = Break-out
field-mended = Mended
field-copy = Copy
field-when = When
field-kind = Kind
field-detail = Detail
field-told = Told
field-outcome = Outcome
field-by = By
field-printer = Printer
field-free-from = Free from
field-since = Since
field-print-times = Print times
field-fires = Fires
field-begins = Begins
field-unpacking = Unpacking
field-closed = Closed
field-to-send = To send
field-done = Done
field-order-or-part = Order or part
field-risk = Risk
field-taken = Taken
field-released = Released
field-reference = Reference
field-withdrawn = Withdrawn
field-waiting = Waiting
field-oldest = Oldest
field-next-build = Next build
field-while-it-waits = While it waits
field-node = Node
field-host = Host
field-last-sign = Last sign
field-address = Address
field-machines = Machines
field-now = Now
field-being-read = Being read
field-last-published = Last published
field-no = No.
field-top = Top
field-bottom = Bottom
field-x = x
field-y = y
field-way = Way

## Words of states, as chips show them: of builds, machines, printers, copies, parts, orders and dates

state-complete = complete
state-good = good
state-kept = kept
state-on-time = on time
state-done = done
state-runs = runs
state-printing = printing
state-should-be-printed = should be printed
state-cooling = cooling
state-nesting = nesting
state-being-made = being made
state-being-read = being read
state-reading = reading
state-under-way = under way
state-open = open
state-waiting = waiting
state-collecting = collecting
state-queued = queued
state-in-the-queue = in the queue
state-at-the-printer = at the printer
state-proved = proved
state-expecting = expecting
state-in-a-build = in a build
state-later = later
state-free = free
state-closed-now = closed now
state-withdrawn = withdrawn
state-cancelled = cancelled
state-closed = closed
state-stopped = stopped
state-no-date = no date
state-tight = tight
state-ended = ended
state-should-be-done = should be done
state-waits-for-a-yes = waits for a yes
state-paused = paused
state-interrupted = interrupted
state-short = short
state-missing = missing
state-is-to-be-repaired = is to be repaired
state-on-its-way-to-another-printer = on its way to another printer
state-being-taken-back = being taken back
state-overdue = overdue
state-late = late
state-failed = failed
state-refused = refused
state-bad = bad
state-down = down
state-unavailable = unavailable
state-does-not-answer = does not answer
details = Details
close = Close
skip = Skip to content
pages = Pages
nav-farm = Farm
nav-orders = Orders
nav-history = History
nav-month = Month
nav-help = Help
search-farm = Search the farm
footer-lengths = . Lengths are mm.
footer-json = JSON interface
footer-metrics = Metrics
search-example = Part, order, build 3
search-key = Press / to search
search = Search
to-the-farm = To the farm

## Titles of error pages

http-bad-request = Bad Request
http-unauthorized = Unauthorized
http-forbidden = Forbidden
http-not-found = Not Found
http-method-not-allowed = Method Not Allowed
http-conflict = Conflict
http-payload-too-large = Payload Too Large
http-misdirected-request = Misdirected Request
http-unprocessable-entity = Unprocessable Entity
http-too-many-requests = Too Many Requests
http-internal-server-error = Internal Server Error
http-service-unavailable = Service Unavailable
http-error = Error

## States of builds as the ledger has them

ledger-open = open
ledger-nesting = nesting
ledger-verified = verified
ledger-published = published
ledger-printing = printing
ledger-complete = complete
ledger-interrupted = interrupted
ledger-failed = failed
ledger-claimed = claimed
ledger-waiting = waiting
ledger-batched = batched
ledger-built = built
ledger-refused = refused

## What happened, as the list of events says it

event-in-a-build = in a build
event-in-the-queue = in the queue
event-waiting = waiting
event-refused = refused
event-open = open
event-nesting = nesting
event-verified = verified
event-published = published
event-printing = printing
event-complete = complete
event-interrupted = interrupted
event-failed = failed
event-paused = paused
event-resumed = resumed
event-unavailable = unavailable
event-available = available
event-adopted = adopted
event-damaged = damaged
event-size-differs = size differs
event-healed = healed
event-at-risk = at risk
event-attempt-failed = attempt failed
event-proof-failed = proof failed
event-locked = locked
event-put-out = put out
event-no-room = no room
event-clock-set = clock set
event-messages-dropped = messages dropped
event-put-back = put back
event-copies-cancelled = copies cancelled
event-copies-wanted = copies wanted
event-edited = edited
event-moved = moved
event-loaded = loaded
event-confirmed = confirmed
event-finishing = finishing
event-revised = revised
event-seen = seen

## What fired a build

trigger-flush = flush
trigger-full = full
trigger-fill = fill
trigger-copies = copies
trigger-max-wait = max_wait
trigger-due = due
trigger-at = at
trigger-withdrawn = withdrawn

turned-free = free
turned-upright = upright
turned-axis = axis
turned-fixed = fixed

## Signs between words

sign-comma = ,{ " " }
sign-semicolon = ;{ " " }
sign-stop = .
sign-colon = :{ " " }

## The reason that lies beside a refused file

cause-and-reason = { $cause }: { $reason }
reason-refused = { $name } was refused.
reason-file = File: { $place }
reason-when = When: { $time }
reason-part = Part { $part } of the machine { $machine }.
reason-retry = To take it back: nestd retry { $part }

# A build or a date with what is known of it.
job-described = { $name }: { $what }.
search-words-build = build builds
search-words-part = part parts file files
search-words-order = order orders
search-words-customer = customer customers
search-words-machine = machine machines
