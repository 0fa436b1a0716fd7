//! The graph of a crate's modules, and the cycles in it.

use super::tokens::References;
use super::*;

/// Modules of one folder that need each other, and one import for each arrow between them.
pub(super) struct Cycle {
    pub(super) modules: Vec<Module>,
    /// From, to, and the import that shows it.
    arrows: Vec<(Module, Module, String)>,
}

impl std::fmt::Display for Cycle {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let names: Vec<String> = self.modules.iter().map(|module| module.join("/")).collect();
        write!(f, "{}", names.join(" ↔ "))?;
        for (from, to, import) in &self.arrows {
            write!(f, "\n    {} needs {}: {import}", from.join("/"), to.join("/"))?;
        }
        Ok(())
    }
}

/// Which sibling modules import from which, with one import that shows it.
pub(super) fn arrows(sources: &Sources) -> BTreeMap<(Module, Module), String> {
    let is_module = |path: &[String]| sources.contains_key(path);
    let references: BTreeMap<&Module, References> =
        sources.iter().map(|(module, (_, text))| (module, references(module, text, &is_module))).collect();
    let mut arrows = BTreeMap::new();
    for (module, of_module) in &references {
        for path in &of_module.paths {
            let target = defining_module(&references, path, 0);
            let common = module.iter().zip(&target).take_while(|(a, b)| a == b).count();
            // Within one branch of the tree a parent and its submodules use each other.
            if common < module.len() && common < target.len() {
                let (file, _) = &sources[*module];
                let file = file.strip_prefix(env!("CARGO_MANIFEST_DIR")).unwrap_or(file);
                let shown = format!("{} names crate::{}", file.display(), path.join("::"));
                let pair = (module[..=common].to_vec(), target[..=common].to_vec());
                arrows.entry(pair).or_insert(shown);
            }
        }
    }
    arrows
}

/// The module that defines what a path names, followed through re-exports.
fn defining_module(references: &BTreeMap<&Module, References>, path: &[String], depth: usize) -> Module {
    let mut module = Module::new();
    for (index, segment) in path.iter().enumerate() {
        let below: Module = module.iter().cloned().chain([segment.clone()]).collect();
        if references.contains_key(&below) {
            module = below;
            continue;
        }
        let imported = references.get(&module).and_then(|found| found.imports.get(segment));
        // Without a limit, two modules that re-export each other would be followed for ever.
        if let Some(imported) = imported.filter(|_| depth < 10) {
            let onward = [&imported[..], &path[index + 1..]].concat();
            return defining_module(references, &onward, depth + 1);
        }
        break;
    }
    module
}

/// Every set of sibling modules that can reach each other.
pub(super) fn cycles(sources: &Sources) -> Vec<Cycle> {
    let arrows = arrows(sources);
    let reached = |from: &Module| {
        let mut reached = BTreeSet::new();
        let mut open = vec![from];
        while let Some(module) = open.pop() {
            for (_, to) in arrows.keys().filter(|(start, _)| start == module) {
                if reached.insert(to) {
                    open.push(to);
                }
            }
        }
        reached
    };
    let mut cycles: Vec<Cycle> = Vec::new();
    for module in arrows.keys().map(|(from, _)| from).collect::<BTreeSet<_>>() {
        let from_here = reached(module);
        if !from_here.contains(module) || cycles.iter().any(|cycle| cycle.modules.contains(module)) {
            continue;
        }
        let back = |other: &&&Module| reached(other).contains(module);
        let modules: Vec<Module> = from_here.iter().filter(back).map(|module| (*module).clone()).collect();
        let inside = arrows.iter().filter(|((from, to), _)| modules.contains(from) && modules.contains(to));
        let arrows = inside.map(|((from, to), import)| (from.clone(), to.clone(), import.clone()));
        cycles.push(Cycle { arrows: arrows.collect(), modules });
    }
    cycles
}
