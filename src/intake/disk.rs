//! Small file-system steps that have to last: what is renamed here is on disk when the function returns.
