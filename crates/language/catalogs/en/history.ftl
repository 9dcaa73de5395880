a-state-of-build = a state of a build
the-number-of-build = the number of a build
is-no-date = '{ $text }' is no date such as 2026-11-20
csv-all-columns = CSV with all columns
next-builds = The builds that come after these
all = all
part-or-order = Part or order, whole name
until = Until
sorted-by-what = Sorted by
newest-first = newest first
show = Show
days =
    { $days ->
        [one] { $days } day
       *[other] { $days } days
    }
published-in-time = What was published in that time
heights = Heights
the-newest-first = the newest first
sorted-by =
    sorted by { $sort ->
        [height] height
        [density] density
        [copies] copies
       *[machine] machine
    }
no-builds = No builds
none-matches = None matches what is asked for above.
all-builds = All builds
is-no-month = '{ $text }' is no month such as 2026-10
as-many-days = as many days of { $month }
month-text = Litres of parts are their volume; litres of cake are parts and powder up to the height of each build. Machine time is the height times the hours that a mm takes. Yield: good copies of those of which somebody told how they came out.
height-by-week = Height by week, mm
figure-builds =
    { $count ->
        [one] build
       *[other] builds
    }
figure-copies-made =
    { $count ->
        [one] copy
       *[other] copies
    }
figure-of-parts = of parts
figure-machine-time = of machine time
figure-yield = yield
figure-late-parts = late
figure-failed =
    { $count ->
       *[other] failed
    }
none = None.
link-on-machine = { $link } on { $machine }
month-caption = Published in this month; in small what it was in { $before }
late = Late
nothing-late = Nothing that was due in this month came late, or will.
late-text =
    { $parts ->
        [one] { $parts } part
       *[other] { $parts } parts
    } of { $orders ->
        [one] { $orders } order
       *[other] { $orders } orders
    } came after the due date, or are not printed yet.
without-order = Without an order
done-about-untold = done about { $time }, as nobody told
done-at = done { $time }
chart-height = Build height
chart-density = Density
chart-used = Height used of the machine's
more-machines =
    and { $count ->
        [one] { $count } more machine
       *[other] { $count } more machines
    }, in the table only
height-curve = Height while it was searched, mm over seconds
height-over-time = Height over time
all-machines = all machines

costs = Costs
costs-by-order = What each order bears
costs-by-build = What each order bears of each build
costs-text = Machine time and powder of a build are shared by the volume of the parts; litres and copies are each order's own. The farm bears copies that came out bad. Rates are those that held when the build was made. Powder is the fresh powder that builds took.
no-prices = Nothing has a price. The rates stand in `[costs]` of a machine's file.
figure-cost = cost
order-costs = It costs { $cost } so far.
farm-bears-bad-copies = bad copies: borne by the farm
csv-by-order = CSV by order
csv-by-build = CSV by build
this-month = This month
