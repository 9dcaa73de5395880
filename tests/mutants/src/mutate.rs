//! Writes mutants into a source file. All mutants of a file stand in it at once; each one is behind a switch, so that one compilation
//! serves all of them: `a < b` becomes `if crate::mutants::is_on(17) { a <= b } else { a < b }`.

use std::collections::{BTreeMap, BTreeSet};

use anyhow::{Context, Result};
use syn::{
    Attribute, BinOp, Block, Expr, ExprBinary, File, ImplItemFn, Item, ItemFn, ItemImpl, ItemMod, Macro, ReturnType,
    Signature, Stmt, Type, UnOp, parse_quote,
    spanned::Spanned,
    visit_mut::{self, VisitMut},
};

/// A mutant: where it is and what it changes.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Mutant {
    /// The file, as it was named.
    pub file: String,
    /// Its line, from 1.
    pub line: usize,
    /// What it does.
    pub what: String,
}

/// Writes mutants into sources and numbers them.
#[derive(Default)]
pub struct Mutator {
    /// All mutants by number, from 1.
    pub mutants: BTreeMap<u32, Mutant>,
    /// Those that do not compile: they are left out.
    pub dropped: BTreeSet<u32>,
    file: String,
    last: u32,
    is_const: bool,
}

impl Mutator {
    /// The source with the mutants in it. Numbers are the same each time for the same files in the same order.
    pub fn mutate(&mut self, file: &str, source: &str) -> Result<String> {
        let mut parsed: File = syn::parse_file(source).with_context(|| format!("reading {file}"))?;
        file.clone_into(&mut self.file);
        self.visit_file_mut(&mut parsed);
        Ok(prettyplease::unparse(&parsed))
    }

    /// Begins again with the first number.
    pub fn restart(&mut self) {
        self.last = 0;
        self.mutants.clear();
    }

    /// The number of the next mutant; `None` = it is left out.
    fn next(&mut self, line: usize, what: String) -> Option<u32> {
        if self.is_const {
            return None;
        }
        self.last += 1;
        if self.dropped.contains(&self.last) {
            return None;
        }
        self.mutants.insert(self.last, Mutant { file: self.file.clone(), line, what });
        Some(self.last)
    }

    /// A function may end at once with a simple value of its type.
    fn add_early_return(&mut self, head: &Signature, body: &mut Block) {
        let values: &[&str] = match &head.output {
            ReturnType::Default => &["()"],
            ReturnType::Type(_, of) => simple_values(of),
        };
        // What is passed by value must not be needed later: the early return stands first.
        for value in values {
            let line = head.ident.span().start().line;
            let Some(number) = self.next(line, format!("{} returns {value} at once", head.ident)) else { continue };
            let Ok(value) = syn::parse_str::<Expr>(value) else { continue };
            body.stmts.insert(0, parse_quote! { if crate::mutants::is_on(#number) { return #value; } });
        }
    }

    fn visit_function(&mut self, attributes: &[Attribute], head: &Signature, body: &mut Block) {
        if is_test(attributes) {
            return;
        }
        let was_const = std::mem::replace(&mut self.is_const, head.constness.is_some());
        visit_mut::visit_block_mut(self, body);
        self.add_early_return(head, body);
        self.is_const = was_const;
    }
}

/// Values that a function of this type may return instead.
fn simple_values(of: &Type) -> &'static [&'static str] {
    let Type::Path(path) = of else { return &[] };
    let Some(last) = path.path.segments.last() else { return &[] };
    let arguments = match &last.arguments {
        syn::PathArguments::AngleBracketed(arguments) => arguments.args.first(),
        _ => None,
    };
    match (last.ident.to_string().as_str(), arguments) {
        ("bool", None) => &["true", "false"],
        ("Option", _) => &["None"],
        ("Vec", _) => &["Vec::new()"],
        ("String", None) => &["String::new()"],
        ("Result", Some(syn::GenericArgument::Type(Type::Tuple(unit)))) if unit.elems.is_empty() => &["Ok(())"],
        ("Result", Some(syn::GenericArgument::Type(Type::Path(inner)))) => match inner.path.segments.last() {
            Some(inner) if inner.ident == "bool" => &["Ok(true)", "Ok(false)"],
            Some(inner) if inner.ident == "Option" => &["Ok(None)"],
            _ => &[],
        },
        _ => &[],
    }
}

fn is_test(attributes: &[Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string().contains("test"),
        meta => meta.path().segments.last().is_some_and(|last| last.ident == "test"),
    })
}

/// Whether a condition binds names, as in `a && let Some(b) = c`: it cannot be moved.
fn binds(of: &Expr) -> bool {
    match of {
        Expr::Let(_) => true,
        Expr::Binary(binary) => binds(&binary.left) || binds(&binary.right),
        Expr::Paren(inner) => binds(&inner.expr),
        _ => false,
    }
}

/// The operators that stand instead of one.
fn other_operators(of: &BinOp) -> Vec<BinOp> {
    match of {
        BinOp::Lt(_) => vec![parse_quote!(<=), parse_quote!(>=)],
        BinOp::Le(_) => vec![parse_quote!(<), parse_quote!(>)],
        BinOp::Gt(_) => vec![parse_quote!(>=), parse_quote!(<=)],
        BinOp::Ge(_) => vec![parse_quote!(>), parse_quote!(<)],
        BinOp::Eq(_) => vec![parse_quote!(!=)],
        BinOp::Ne(_) => vec![parse_quote!(==)],
        BinOp::And(_) => vec![parse_quote!(||)],
        BinOp::Or(_) => vec![parse_quote!(&&)],
        BinOp::Add(_) => vec![parse_quote!(-)],
        BinOp::Sub(_) => vec![parse_quote!(+)],
        BinOp::Mul(_) => vec![parse_quote!(/)],
        BinOp::Div(_) => vec![parse_quote!(*)],
        _ => Vec::new(),
    }
}

fn operator_text(of: &BinOp) -> &'static str {
    match of {
        BinOp::Lt(_) => "<",
        BinOp::Le(_) => "<=",
        BinOp::Gt(_) => ">",
        BinOp::Ge(_) => ">=",
        BinOp::Eq(_) => "==",
        BinOp::Ne(_) => "!=",
        BinOp::And(_) => "&&",
        BinOp::Or(_) => "||",
        BinOp::Add(_) => "+",
        BinOp::Sub(_) => "-",
        BinOp::Mul(_) => "*",
        _ => "/",
    }
}

/// Whether a statement without it would still compile, and a test should notice.
fn is_removable(of: &Expr) -> bool {
    match of {
        Expr::Call(_) | Expr::MethodCall(_) | Expr::Await(_) | Expr::Assign(_) => true,
        Expr::Try(tried) => is_removable(&tried.expr),
        Expr::Binary(binary) => matches!(
            binary.op,
            BinOp::AddAssign(_)
                | BinOp::SubAssign(_)
                | BinOp::MulAssign(_)
                | BinOp::BitOrAssign(_)
                | BinOp::BitAndAssign(_)
        ),
        _ => false,
    }
}

impl VisitMut for Mutator {
    fn visit_item_mut(&mut self, item: &mut Item) {
        match item {
            Item::Const(_) | Item::Static(_) | Item::Macro(_) | Item::Type(_) | Item::Enum(_) => {}
            other => visit_mut::visit_item_mut(self, other),
        }
    }

    fn visit_item_mod_mut(&mut self, item: &mut ItemMod) {
        if !is_test(&item.attrs) {
            visit_mut::visit_item_mod_mut(self, item);
        }
    }

    fn visit_item_impl_mut(&mut self, item: &mut ItemImpl) {
        // How something is shown to developers decides nothing.
        let shows = item
            .trait_
            .as_ref()
            .and_then(|(_, path, _)| path.segments.last())
            .is_some_and(|last| last.ident == "Debug");
        if !is_test(&item.attrs) && !shows {
            visit_mut::visit_item_impl_mut(self, item);
        }
    }

    fn visit_item_fn_mut(&mut self, item: &mut ItemFn) {
        self.visit_function(&item.attrs.clone(), &item.sig.clone(), &mut item.block);
    }

    fn visit_impl_item_fn_mut(&mut self, item: &mut ImplItemFn) {
        self.visit_function(&item.attrs.clone(), &item.sig.clone(), &mut item.block);
    }

    fn visit_impl_item_const_mut(&mut self, _: &mut syn::ImplItemConst) {}

    fn visit_pat_mut(&mut self, _: &mut syn::Pat) {}

    fn visit_type_mut(&mut self, _: &mut Type) {}

    fn visit_macro_mut(&mut self, _: &mut Macro) {}

    fn visit_stmt_mut(&mut self, statement: &mut Stmt) {
        let line = statement.span().start().line;
        let removable = match &*statement {
            Stmt::Expr(of, Some(_)) if is_removable(of) => Some(first_words(of)),
            _ => None,
        };
        visit_mut::visit_stmt_mut(self, statement);
        if let Some(what) = removable
            && let Some(number) = self.next(line, format!("without `{what}`"))
        {
            let kept = statement.clone();
            *statement = parse_quote! { if !crate::mutants::is_on(#number) { #kept } };
        }
    }

    fn visit_expr_mut(&mut self, of: &mut Expr) {
        visit_mut::visit_expr_mut(self, of);
        let line = of.span().start().line;
        match of {
            Expr::Binary(binary) if !binds(&binary.left) && !binds(&binary.right) => {
                let ExprBinary { left, op, right, .. } = binary.clone();
                let mut mutated = of.clone();
                for other in other_operators(&op) {
                    let what = format!("{} -> {}", operator_text(&op), operator_text(&other));
                    let Some(number) = self.next(line, what) else { continue };
                    mutated =
                        parse_quote! { (if crate::mutants::is_on(#number) { #left #other #right } else { #mutated }) };
                }
                *of = mutated;
            }
            Expr::Unary(unary) if matches!(unary.op, UnOp::Not(_)) && !binds(&unary.expr) => {
                let inner = unary.expr.clone();
                let Some(number) = self.next(line, "without !".to_owned()) else { return };
                let kept = of.clone();
                *of = parse_quote! { (if crate::mutants::is_on(#number) { #inner } else { #kept }) };
            }
            _ => {}
        }
    }
}

/// The first words of a statement.
fn first_words(of: &Expr) -> String {
    let statement: Stmt = Stmt::Expr(of.clone(), Some(Default::default()));
    let shown: ItemFn = parse_quote! { fn shown() { #statement } };
    let text = prettyplease::unparse(&File { shebang: None, attrs: Vec::new(), items: vec![Item::Fn(shown)] });
    let body: Vec<&str> = text.lines().skip(1).map(str::trim).take_while(|line| *line != "}").collect();
    body.join(" ").chars().take(70).collect()
}
