//! The paths to modules of the same crate that a source file names.

use super::*;

/// What a file says about other modules of its crate.
#[derive(Default)]
pub(super) struct References {
    /// Absolute paths that the file names, in `use` declarations and in code.
    pub(super) paths: Vec<Vec<String>>,
    /// What each imported name stands for, as an absolute path.
    pub(super) imports: BTreeMap<String, Vec<String>>,
}

/// Reads a module's references. `is_module` says whether an absolute path is one of the crate's modules: in a `use`
/// declaration a path may begin with a submodule of its own.
pub(super) fn references(module: &Module, text: &str, is_module: &dyn Fn(&[String]) -> bool) -> References {
    let mut reader = Reader { is_module, found: References::default() };
    let tokens = TokenStream::from_str(text).expect("sources are Rust");
    reader.read(module, tokens);
    reader.found
}

struct Reader<'a> {
    is_module: &'a dyn Fn(&[String]) -> bool,
    found: References,
}

impl Reader<'_> {
    fn read(&mut self, module: &Module, tokens: TokenStream) {
        let tokens: Vec<TokenTree> = tokens.into_iter().collect();
        let mut at = 0;
        while at < tokens.len() {
            match (&tokens[at], tokens.get(at + 1)) {
                (TokenTree::Punct(hash), Some(TokenTree::Group(attribute)))
                    if hash.as_char() == '#' && attribute.stream().to_string().replace(' ', "") == "cfg(test)" =>
                {
                    at = end_of_item(&tokens, at + 2);
                }
                (TokenTree::Ident(word), Some(TokenTree::Ident(name))) if word == "mod" => {
                    // An inline module: `super` in it is the module around it.
                    if let Some(TokenTree::Group(body)) = tokens.get(at + 2) {
                        let inner = module.iter().cloned().chain([name.to_string()]).collect();
                        self.read(&inner, body.stream());
                        at += 3;
                    } else {
                        at += 2;
                    }
                }
                (TokenTree::Ident(word), _) if word == "use" => {
                    let end = (at..tokens.len()).find(|index| is_punct(&tokens[*index], ';'));
                    let end = end.unwrap_or(tokens.len());
                    self.read_use(module, &mut Vec::new(), &tokens[at + 1..end]);
                    at = end + 1;
                }
                (TokenTree::Ident(word), _) if ["crate", "self", "super"].contains(&word.to_string().as_str()) => {
                    let (segments, next) = path(&tokens, at);
                    if segments.len() > 1
                        && let Some(absolute) = self.absolute(module, &segments)
                    {
                        self.found.paths.push(absolute);
                    }
                    at = next;
                }
                (TokenTree::Group(group), _) => {
                    self.read(module, group.stream());
                    at += 1;
                }
                _ => at += 1,
            }
        }
    }

    /// Reads a tree of imports after the path `before`: `a::{b, c as d}`.
    fn read_use(&mut self, module: &Module, before: &mut Vec<String>, tokens: &[TokenTree]) {
        for tree in tokens.split(|token| is_punct(token, ',')).filter(|tree| !tree.is_empty()) {
            let (segments, next) = path(tree, 0);
            let length = before.len();
            before.extend(segments);
            match tree.get(next) {
                Some(TokenTree::Group(group)) if group.delimiter() == Delimiter::Brace => {
                    let inner: Vec<TokenTree> = group.stream().into_iter().collect();
                    self.read_use(module, before, &inner);
                }
                rest => {
                    let renamed = match (rest, tree.get(next + 1)) {
                        (Some(TokenTree::Ident(word)), Some(TokenTree::Ident(name))) if word == "as" => Some(name),
                        _ => None,
                    };
                    let mut leaf = before.clone();
                    // `a::{self}` is `a`.
                    if leaf.len() > 1 && leaf.last().is_some_and(|last| last == "self") {
                        leaf.pop();
                    }
                    if let Some(absolute) = self.absolute(module, &leaf) {
                        let name = renamed.map(ToString::to_string).or(leaf.last().cloned());
                        self.found.imports.extend(name.map(|name| (name, absolute.clone())));
                        self.found.paths.push(absolute);
                    }
                }
            }
            before.truncate(length);
        }
    }

    /// The path from the crate's root; `None` for one that leads to another crate.
    fn absolute(&self, module: &Module, segments: &[String]) -> Option<Vec<String>> {
        let mut from = module.clone();
        let mut rest = segments;
        match segments.first()?.as_str() {
            "crate" => {
                from.clear();
                rest = &rest[1..];
            }
            "self" => rest = &rest[1..],
            "super" => {}
            name => {
                from.push(name.to_string());
                return (self.is_module)(&from).then(|| [&module[..], segments].concat());
            }
        }
        while rest.first().is_some_and(|segment| segment == "super") {
            from.pop();
            rest = &rest[1..];
        }
        Some([&from[..], rest].concat())
    }
}

/// The identifiers joined by `::` that begin at `at`, and the index after them.
fn path(tokens: &[TokenTree], mut at: usize) -> (Vec<String>, usize) {
    let mut segments = Vec::new();
    while let Some(TokenTree::Ident(segment)) = tokens.get(at) {
        segments.push(segment.to_string());
        at += 1;
        let joined = tokens.len() > at + 1 && is_punct(&tokens[at], ':') && is_punct(&tokens[at + 1], ':');
        if !joined {
            break;
        }
        at += 2;
    }
    (segments, at)
}

/// The index after an item that begins at `at`: after its body or its semicolon.
fn end_of_item(tokens: &[TokenTree], at: usize) -> usize {
    let end = (at..tokens.len()).find(|index| match &tokens[*index] {
        TokenTree::Group(group) => group.delimiter() == Delimiter::Brace,
        token => is_punct(token, ';'),
    });
    end.map_or(tokens.len(), |end| end + 1)
}

fn is_punct(token: &TokenTree, wanted: char) -> bool {
    matches!(token, TokenTree::Punct(punct) if punct.as_char() == wanted)
}
