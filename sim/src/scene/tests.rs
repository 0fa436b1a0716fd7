//! Scene files that users wrote for earlier versions, and the lines of errors.

#![allow(clippy::unwrap_used, reason = "a test may end in a panic")]

use underbrush_recording::Category;

use super::Scene;
use crate::reach::ReachPlan;

/// Tests that a group's category goes into the truth of a reach, and that everything else in the draw stays as it is
/// without it.
#[test]
fn a_named_category_changes_nothing_but_the_truth() {
    let drawn = |category: &str| {
        let text = format!(
            "summary = \"A test\"\n[[objects.trunk]]\ncount = 2\n[[objects.trunk]]\ncount = 1\n{category}place = {{ x_m = 0.6 }}\n"
        );
        let plan = ReachPlan::new(Scene::parse("test.toml", text).unwrap(), None, 3).unwrap();
        plan.draw(0).unwrap().records()
    };
    let (usual, mut named) = (drawn(""), drawn("category = \"post\"\n"));
    assert_eq!(named.iter().map(|own| own.category.name()).collect::<Vec<_>>(), ["trunk", "trunk", "post"]);
    named.iter_mut().for_each(|own| own.category = Category::TRUNK);
    assert_eq!(named, usual);
}

/// Tests that the category of another kind keeps its code, and that verdicts, bad names and two names with one code are
/// refused with the line.
#[test]
fn categories_have_allowed_names() {
    let scene = |first: &str, second: &str| {
        let text = format!(
            "summary = \"A test\"\n[[objects.trunk]]\ncount = 1\ncategory = \"{first}\"\n[[objects.leaf]]\ncount = 0\n\
             category = \"{second}\"\n"
        );
        Scene::parse("test.toml", text)
    };
    let bottle = scene("bottle", "leaf").unwrap();
    assert_eq!(bottle.file.objects.groups()[0].2.category.code(), 4);
    for name in ["unknown", "Post", "a post", ""] {
        let error = scene("pole", name).unwrap_err();
        assert_eq!(error.line, Some(7), "{error}");
    }
    let code = |name: &str| Category::named(name).unwrap().code();
    let twin = (0..).map(|number| format!("post{number}")).find(|name| code(name) == code("pole")).unwrap();
    let error = scene("pole", &twin).unwrap_err();
    assert_eq!((error.field.as_str(), error.line), ("objects.leaf[0].category", Some(7)), "{error}");
}

/// Tests that the line of an error about a group that is an inline table, or has dotted keys, is the group's own.
#[test]
fn groups_without_a_header_have_their_own_lines() {
    for text in [
        "goals = { count = 0 }\n[[objects.foam_block]]\ncount = 2\n",
        "goals.count = 2000\n[[objects.trunk]]\ncount = 2\n",
        "objects = { trunk = [ { count = 20000 } ] }\n[goals]\ncount = 3\n",
        "workspace.x_m = [0.5, 0.2]\n[goals]\nx_m = 0.5\n",
    ] {
        let error = Scene::parse("test.toml", format!("summary = \"A test\"\n{text}")).unwrap_err();
        assert_eq!(error.line, Some(2), "{error}");
    }
}
