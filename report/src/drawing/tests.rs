use proptest::prelude::*;

use super::*;
use crate::tests::{Element, elements};

fn attribute<'a>(element: &'a Element, name: &str) -> Option<&'a str> {
    element.1.iter().find(|own| own.0 == name).map(|own| own.1.as_str())
}

fn chart(x: Axis, y: Axis, layers: Vec<Layer>) -> Chart {
    Chart { name: "a chart".into(), title: "Force & motion".into(), description: "Rises < 3 N".into(), x, y, layers }
}

/// A linear axis over all data.
fn linear(label: &str) -> Axis {
    Axis { label: label.into(), scale: Scale::Linear { low: None, high: None } }
}

/// A table without rows.
fn empty(name: &str, caption: &str, columns: &[&str]) -> Table {
    let columns = columns.iter().map(|&column| column.into()).collect();
    Table { name: name.into(), caption: caption.into(), columns, rows: Vec::new() }
}

const STYLES: [Style; 3] = [
    Style::line("#009e73", Dash::Solid),
    Style::marked("#d55e00", Dash::Dashed, Mark::Triangle),
    Style::marked("#0072b2", Dash::Dotted, Mark::Ring),
];

/// Any number, mostly ordinary ones.
fn number() -> impl Strategy<Value = f64> {
    prop_oneof![4 => -100.0..100.0_f64, 1 => any::<f64>(), 1 => Just(f64::NAN), 1 => Just(f64::INFINITY), 1 => Just(0.0)]
}

fn shape() -> impl Strategy<Value = Shape> {
    let pairs = || prop::collection::vec((number(), number()), 0..40);
    prop_oneof![
        pairs().prop_map(Shape::Line),
        pairs().prop_map(Shape::Steps),
        pairs().prop_map(Shape::Areas),
        pairs().prop_map(Shape::Bands),
        prop::collection::vec(number(), 0..8).prop_map(Shape::Bars),
        prop::collection::vec((number(), number(), number(), number()), 0..20).prop_map(|points| {
            let point = |(x, y, low, high)| Point { x, y, interval: Some((low, high)) };
            Shape::Points(points.into_iter().map(point).collect())
        }),
    ]
}

fn axis() -> impl Strategy<Value = Axis> {
    prop_oneof![
        Just(linear("x / m")),
        Just(Axis::from_zero("x / m")),
        Just(Axis::spanning("share / %", 0.0, 100.0)),
        Just(Axis::logarithmic("t / s")),
        Just(Axis::names("which", ["a<b", "\"c\"", "d&e"])),
    ]
}

proptest! {
    #[test]
    fn any_data_make_well_formed_svg(
        x in axis(), y in axis(), shapes in prop::collection::vec((shape(), 0..3_usize, "\\PC{0,12}"), 0..4)
    ) {
        // Tests that with any data (none, NaN, infinity, huge), a chart is XML that an independent parser reads, no
        // coordinate is NaN or infinite, and everything lies within the view box.
        let layers = shapes.into_iter().map(|(shape, style, name)| Layer::new(name, STYLES[style], shape)).collect();
        let svg = chart(x, y, layers).svg();
        let elements = elements(&svg);
        prop_assert!(!svg.contains("NaN") && !svg.contains("inf"), "{svg}");
        let view: Vec<f64> = attribute(&elements[0], "viewBox").unwrap().split(' ').map(|n| n.parse().unwrap()).collect();
        for element in elements.iter().filter(|element| ["polyline", "polygon"].contains(&element.0.as_str())) {
            for pair in attribute(element, "points").unwrap().split_terminator(' ') {
                let (x, y) = pair.split_once(',').unwrap();
                let (x, y): (f64, f64) = (x.parse().unwrap(), y.parse().unwrap());
                prop_assert!((0.0..=view[2]).contains(&x) && (0.0..=view[3]).contains(&y), "{pair}");
            }
        }
    }

    #[test]
    fn csv_is_read_back(texts in prop::collection::vec("[ -~\\n]{0,9}", 1..5), value in number()) {
        // Tests that an independent reader (the csv crate, RFC 4180) finds the same words and the same number, bit for
        // bit.
        let columns: Vec<&str> = texts.iter().map(String::as_str).chain(["value"]).collect();
        let mut table = empty("t", "caption", &columns);
        table.rows.push(texts.iter().map(|text| text.as_str().into()).chain([Cell::Number(value, 2)]).collect());
        let csv = table.csv();
        let mut reader = csv::ReaderBuilder::new().has_headers(false).from_reader(csv.as_bytes());
        let rows: Vec<csv::StringRecord> = reader.records().map(Result::unwrap).collect();
        prop_assert_eq!(rows.len(), 2);
        prop_assert_eq!(rows[0].iter().collect::<Vec<_>>(), columns);
        prop_assert_eq!(rows[1].iter().take(texts.len()).collect::<Vec<_>>(), texts.iter().collect::<Vec<_>>());
        match rows[1][texts.len()].parse::<f64>() {
            Ok(found) => prop_assert_eq!(found, value),
            Err(_) => prop_assert!(!value.is_finite()),
        }
    }
}

#[test]
fn a_chart_says_what_it_shows() {
    // Tests the alternative text: role, title and description with the names that aria-labelledby refers to.
    let svg = chart(linear("t / s"), linear("force / N"), Vec::new()).svg();
    let elements = elements(&svg);
    assert_eq!(attribute(&elements[0], "role"), Some("img"));
    let labels: Vec<&str> = attribute(&elements[0], "aria-labelledby").unwrap().split(' ').collect();
    for (label, (name, text)) in labels.iter().zip([("title", "Force & motion"), ("desc", "Rises < 3 N")]) {
        let element = elements.iter().find(|element| element.0 == name).unwrap();
        assert_eq!(attribute(element, "id"), Some(*label));
        assert_eq!(element.2, text);
    }
    let words: Vec<&str> = elements.iter().filter(|element| element.0 == "text").map(|own| own.2.as_str()).collect();
    assert!(words.contains(&"t / s") && words.contains(&"force / N"), "{words:?}");
}

#[test]
fn a_line_lies_where_its_axes_say() {
    // Tests that scales and ticks agree: a line through (0, 0) and (10, 100) passes through the positions of these
    // ticks.
    let line = Shape::Line(vec![(0.0, 0.0), (10.0, 100.0)]);
    let svg = chart(linear("x"), linear("y"), vec![Layer::new("", STYLES[0], line)]).svg();
    let elements = elements(&svg);
    let place = |text: &str, axis: &str| -> Vec<f64> {
        let ticks = elements.iter().filter(|element| element.0 == "text" && element.2 == text);
        ticks.map(|tick| attribute(tick, axis).unwrap().parse().unwrap()).collect()
    };
    let points = elements.iter().find(|element| element.0 == "polyline").unwrap();
    let points: Vec<f64> = attribute(points, "points").unwrap().split([' ', ',']).map(|n| n.parse().unwrap()).collect();
    // The text of a tick of y stands 5 px below its line.
    assert!(place("10", "x").contains(&points[2]), "{svg}");
    assert!(place("100", "y").iter().any(|y| (y - 5.0 - points[3]).abs() < 0.11), "{svg}");
    assert!(place("0", "x").contains(&points[0]), "{svg}");
}

#[test]
fn bars_stand_on_each_other() {
    // Tests stacking: the second layer's bars begin where the first layer's end, and heights match values.
    let bars = |heights: [f64; 2]| Layer::new("share", STYLES[0], Shape::Bars(heights.to_vec()));
    let svg = chart(
        Axis::names("reach", ["1", "2"]),
        Axis::spanning("share / %", 0.0, 100.0),
        vec![bars([60.0, 25.0]), bars([40.0, 75.0])],
    )
    .svg();
    let number = |element: &Element, name| -> f64 { attribute(element, name).unwrap().parse().unwrap() };
    let elements = elements(&svg);
    // The first two are the legend's keys.
    let rects: Vec<_> = elements.iter().filter(|element| element.0 == "rect").skip(2).collect();
    assert_eq!(rects.len(), 4);
    for (lower, upper) in [(0, 2), (1, 3)] {
        assert_eq!(number(rects[lower], "x"), number(rects[upper], "x"));
        let top = number(rects[lower], "y");
        assert!((number(rects[upper], "y") + number(rects[upper], "height") - top).abs() < 0.11);
    }
    assert!((number(rects[0], "height") / number(rects[2], "height") - 1.5).abs() < 0.01);
}

#[test]
fn areas_stand_on_each_other_and_bands_under_them() {
    // Tests that the lower outline of the second area is the upper one of the first, at the height of its values; and
    // that the strips of two layers of bands overlap neither the areas nor each other, and are at the right times.
    let area = |heights: [f64; 3]| {
        let points = heights.into_iter().enumerate().map(|(x, y)| (x as f64, y));
        Layer::new("", STYLES[0], Shape::Areas(points.collect()))
    };
    let band = |from: f64, to: f64| Layer::new("", STYLES[0], Shape::Bands(vec![(from, to)]));
    let svg = chart(
        linear("t / s"),
        Axis::from_zero("taxels"),
        vec![area([1.0, 3.0, 3.0]), area([2.0, 0.5, 0.5]), band(0.0, 1.0), band(1.0, 2.0)],
    )
    .svg();
    let elements = elements(&svg);
    let outlines: Vec<Vec<(f64, f64)>> = elements
        .iter()
        .filter(|element| element.0 == "polygon")
        .map(|element| {
            let pairs = attribute(element, "points").unwrap().split(' ');
            let pairs = pairs.map(|pair| pair.split_once(',').unwrap());
            pairs.map(|(x, y)| (x.parse().unwrap(), y.parse().unwrap())).collect()
        })
        .collect();
    // Three values give five corners on each edge.
    let [first, second] = &outlines[..] else { panic!("{svg}") };
    assert_eq!(first.len(), 10);
    let upper: Vec<_> = first[..5].iter().rev().copied().collect();
    assert_eq!(upper, second[5..]);
    let px = |outline: &[(f64, f64)], step: usize| outline[9 - step].1 - outline[step].1;
    assert!((px(first, 2) / px(first, 0) - 3.0).abs() < 0.01 && (px(second, 0) / px(first, 0) - 2.0).abs() < 0.01);

    let number = |element: &Element, name| -> f64 { attribute(element, name).unwrap().parse().unwrap() };
    let strips: Vec<_> = elements.iter().filter(|element| element.0 == "rect").collect();
    let base = first[9].1;
    assert!(number(strips[0], "y") > base);
    assert!(number(strips[0], "y") + number(strips[0], "height") < number(strips[1], "y"));
    for (strip, place) in strips.iter().zip([0, 2]) {
        assert!((number(strip, "x") - first[place].0).abs() < 0.11);
        assert!((number(strip, "width") - (first[place + 2].0 - first[place].0)).abs() < 0.11);
    }
}

#[test]
fn a_column_of_numbers_stands_right() {
    // Tests that a heading, its numbers and a word among them are aligned right, and that a column of words or of
    // unknown values is aligned left.
    let mut table = empty("t", "caption", &["words", "numbers", "nothing"]);
    table.rows.push(vec!["a".into(), "all".into(), Cell::Missing]);
    table.rows.push(vec!["b".into(), Cell::Number(0.5, 1), Cell::Missing]);
    let elements = elements(&table.html());
    let of = |name: &str| -> Vec<Option<&str>> {
        let own = elements.iter().filter(|element| element.0 == name);
        own.map(|element| attribute(element, "class")).collect()
    };
    let row = [None, Some("number"), None];
    assert_eq!(of("th"), row);
    assert_eq!(of("td"), [row, row].concat());
}

#[test]
fn no_peak_is_lost() {
    // Tests that a drawing of 100 000 samples with one peak keeps the peak, with far fewer points.
    let mut points: Vec<(f64, f64)> = (0..100_000).map(|i| (f64::from(i), 0.0)).collect();
    points[31_416].1 = 1.0;
    let svg = |points: &[(f64, f64)]| {
        let line = Layer::new("", STYLES[0], Shape::Line(points.to_vec()));
        chart(linear("x"), Axis::spanning("y", 0.0, 1.0), vec![line]).svg()
    };
    let full = svg(&points);
    let [with_peak, only_ends] = [&full, &svg(&[points[0], (50_000.0, 1.0), points[99_999]])].map(|svg| {
        let line = elements(svg).into_iter().find(|element| element.0 == "polyline").unwrap();
        let ys = attribute(&line, "points").unwrap().split(' ').map(|pair| {
            let y: f64 = pair.split_once(',').unwrap().1.parse().unwrap();
            y
        });
        ys.fold(f64::INFINITY, f64::min)
    });
    assert_eq!(with_peak, only_ends);
    assert!(full.len() < 60_000, "{}", full.len());
}

#[test]
fn a_page_is_well_formed_and_escapes() {
    // Tests that text cannot break out of the page, every section is folded with its own address, a card without statements is left
    // out, and tables link to their numbers.
    let mut page = Page::new("Leaf <or> trunk");
    page.cards([("Agrees", vec!["1 < 2".into()]), ("Does not", Vec::new())]);
    page.section("Table I & more");
    page.paragraph("a < b");
    page.section("What was run");
    let mut table = empty("table_1", "Accuracy", &["by", "%"]);
    table.rows.push(vec!["<script>".into(), Cell::Number(81.4, 1)]);
    page.table(&table);
    page.figure("A figure", &[chart(linear("x"), linear("y"), Vec::new()).svg()]);
    let html = page.html();
    let document = html.strip_prefix("<!DOCTYPE html>\n").unwrap();
    let elements = elements(document);
    let count = |name: &str| elements.iter().filter(|element| element.0 == name).count();
    assert_eq!(["script", "h2", "details", "summary"].map(count), [1, 3, 2, 2]);
    let links: Vec<&str> = elements.iter().filter_map(|element| attribute(element, "href")).collect();
    assert_eq!(links, ["csv/table_1.csv"]);
    assert!(elements.iter().any(|element| attribute(element, "id") == Some("table-i-more")));
    assert!(elements.iter().any(|element| element.0 == "td" && element.2 == "<script>"));
}

/// Tests that a dot plot has a row for each name, with marks where their values are along the axis, and whiskers between the ends of
/// intervals.
#[test]
fn a_dot_plot_has_a_row_for_each_name() {
    let points =
        [(0.0, 25.0), (1.0, 75.0), (1.0, 50.0)].map(|(x, y)| Point { x, y, interval: Some((y - 10.0, y + 10.0)) });
    let style = Style::marked("#000000", Dash::Dotted, Mark::Circle);
    let layer = Layer::new("here", style, Shape::Points(points.to_vec()));
    let axes = (Axis::names("", ["first", "second"]), Axis::spanning("accuracy / %", 0.0, 100.0));
    let chart = chart(axes.0, axes.1, vec![layer]);
    let elements = elements(&chart.dot_plot());
    let number = |element: &Element, name: &str| attribute(element, name).unwrap().parse::<f64>().unwrap();
    let circles =
        elements.iter().filter(|element| element.0 == "circle").map(|own| (number(own, "cx"), number(own, "cy")));
    // The first one is in the legend.
    let marks: Vec<(f64, f64)> = circles.skip(1).collect();
    assert!((marks[2].0 - 0.5 * (marks[0].0 + marks[1].0)).abs() < 0.11, "half-way between 25 and 75: {marks:?}");
    assert_eq!(marks[1].1, marks[2].1);
    let rows: Vec<f64> =
        ["first", "second"].map(|name| number(elements.iter().find(|own| own.2 == name).unwrap(), "y")).into();
    assert!((rows[1] - rows[0] - (marks[1].1 - marks[0].1)).abs() < 0.11, "{rows:?}, {marks:?}");
    let whiskers = elements.iter().filter(|element| attribute(element, "stroke-width") == Some("1.6"));
    assert_eq!(whiskers.count(), 3);
}

/// Tests that a long name in the legend is squeezed into the drawing, and a short one is not.
#[test]
fn a_long_name_fits_into_the_legend() {
    let long = "name ".repeat(20);
    let line = || Shape::Line(vec![(0.0, 0.0), (1.0, 1.0)]);
    let layers = vec![Layer::new("short", STYLES[0], line()), Layer::new(long.as_str(), STYLES[1], line())];
    let elements = elements(&chart(linear("x"), linear("y"), layers).svg());
    let words = |name: &str| elements.iter().find(|own| own.0 == "text" && own.2 == name).unwrap();
    assert_eq!(attribute(words("short"), "textLength"), None);
    let width: f64 = attribute(&elements[0], "viewBox").unwrap().split(' ').nth(2).unwrap().parse().unwrap();
    let number = |name: &str| attribute(words(&long), name).unwrap().parse::<f64>().unwrap();
    assert!(number("x") + number("textLength") <= width);
}

/// Tests that a long title, long labels of axes and the names of strips lie within the drawing, and that the data make room for
/// the name of a strip.
#[test]
fn long_texts_stay_in_the_drawing() {
    let long = "name ".repeat(20);
    let name = "a".repeat(24);
    let band = Layer::new(name.as_str(), STYLES[0], Shape::Bands(vec![(0.0, 1.0)]));
    let chart = Chart { title: long.clone(), ..chart(linear(&long), linear("y"), vec![band]) };
    let elements = elements(&chart.svg());
    let number = |own: &Element, name: &str| attribute(own, name).unwrap().parse::<f64>().unwrap();
    let words = |name: &str| elements.iter().filter(|own| own.0 == "text" && own.2 == name).collect::<Vec<_>>();
    let width: f64 = attribute(&elements[0], "viewBox").unwrap().split(' ').nth(2).unwrap().parse().unwrap();
    let [title, label] = words(&long)[..] else { panic!("{elements:?}") };
    assert!(number(title, "x") + number(title, "textLength") <= width);
    // A label of the horizontal axis ends at its x.
    assert!(number(label, "x") <= width && number(label, "x") - number(label, "textLength") >= 0.0);
    // 24 letters need 200 px.
    let strip = elements.iter().find(|own| own.0 == "rect").unwrap();
    assert!(number(strip, "x") > 200.0 && number(words(&name)[0], "x") < number(strip, "x"));
    assert_eq!(attribute(words(&name)[0], "textLength"), None);
}

/// Tests that long names of a dot plot take at most 60 % of its width.
#[test]
fn long_names_leave_room_for_the_dots() {
    let long = "name ".repeat(20);
    let style = Style::marked("#000000", Dash::Dotted, Mark::Circle);
    let layer = Layer::new("here", style, Shape::Points(vec![Point { x: 0.0, y: 25.0, interval: None }]));
    let axes = (Axis::names("", [long.as_str()]), Axis::spanning("accuracy / %", 0.0, 100.0));
    let elements = elements(&chart(axes.0, axes.1, vec![layer]).dot_plot());
    let name = elements.iter().find(|own| own.0 == "text" && own.2 == long).unwrap();
    let number = |name_of: &str| attribute(name, name_of).unwrap().parse::<f64>().unwrap();
    assert!(number("x") <= 324.0 && number("x") - number("textLength") >= 0.0);
}
