mail-refused-subject = { $machine }: { $name } was refused
mail-refused = The file { $name } was refused by { $machine }:
mail-refused-of-order = The file { $name } of order { $order } was refused by { $machine }:
mail-refused-nameless-subject = { $machine }: a file was refused
mail-refused-nameless = A file that was dropped was refused by { $machine }:
mail-refused-several =
    { $count ->
        [one] { $machines }: { $count } file was refused
       *[other] { $machines }: { $count } files were refused
    }
mail-at-risk-subject = { $machine }: a due date is at risk
mail-at-risk-subject-order = Order { $order } on { $machine }: the due date is at risk
mail-at-risk = On { $machine }, parts may be late:
mail-at-risk-several =
    { $count ->
        [one] { $machines }: { $count } due date is at risk
       *[other] { $machines }: { $count } due dates are at risk
    }
mail-alerts-several =
    { $count ->
        [one] { $machines }: { $count } thing needs a person
       *[other] { $machines }: { $count } things need a person
    }
mail-dropped-subject = Messages of the print farm could not be delivered
mail-dropped = Messages could not be delivered, and will not be sent again: { $what }.
mail-complete-subject = Your order { $order } is complete
mail-complete-several = Your orders { $orders } are complete
mail-complete = Your order { $order } is complete. All its parts are printed:
mail-complete-line = { $copies } × { $name }
mail-complete-more =
    { $count ->
        [one] and { $count } more part
       *[other] and { $count } more parts
    }
mail-footer = nestd wrote this mail on the server { $host }, where it runs the print farm. The dashboard of the farm says more.
mail-footer-customer = The software of the print farm wrote this mail.
mail-trial-subject = A test mail of the print farm
mail-trial = This is a test. nestd on the server { $host } can send you mails about the print farm.
