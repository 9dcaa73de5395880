-- Nothing is left to fold here: nestd itself folded the name of every order. The number is that of SQLite's schema.
COMMENT ON COLUMN customer_order.folded IS 'its name in lower case, to be searched without regard to case';
