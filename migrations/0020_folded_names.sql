-- Orders are found in any letter case, also of letters that are not ASCII: SQLite's lower(), which folded the names of earlier orders,
-- left those as they were. An empty text stands for what nestd folds itself, in the same transaction.
UPDATE customer_order SET folded = '' WHERE name GLOB '*[^ -~]*';
