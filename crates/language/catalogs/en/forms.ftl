drop-time-needs-date = a time of day needs its date
no-whole-number = { $field }: '{ $text }' is no whole number
files-of = { $formats } files
drop-copies = Copies of each file; empty = as its name says (bracket_x10.stl), else 1
drop-due = Due (the end of that day, unless with a time)
drop-more = Turning, priority, note
drop-orientation = How the parts may be turned
orientation-machine = as the machine allows
drop-priority = Priority, 0 to 100; 100 must be in the next build
files-sent-to = Files that are sent to { $machine }
add-to = Add to { $machine }
orientation-free = free: any way
orientation-upright = upright: about the vertical
orientation-axis = axis: in right angles
orientation-fixed = fixed: as in the file
