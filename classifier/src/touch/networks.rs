//! The two networks of a touch model, fitted to rows of reaches.

use super::course::REGION_FEATURE_COUNT;
use super::example::Examples;
use super::network::{Network, Row};
use super::taxel::TAXEL_FEATURE_COUNT;
use super::usual::Usual;

/// Index of a category; zero if it is none of them.
pub(super) fn class(categories: &[String], category: &str) -> usize {
    categories.iter().position(|own| own == category).unwrap_or_default()
}

pub(super) fn touched_network(reaches: &[&Examples]) -> Network {
    let taxels = reaches.iter().flat_map(|reach| &reach.taxels);
    let rows: Vec<Row<TAXEL_FEATURE_COUNT>> = taxels
        .map(|taxel| Row { features: taxel.features, class: usize::from(taxel.is_touched), weight: 1.0 })
        .collect();
    Network::fit(&rows, 2)
}

/// A region counts as often as it has touched taxels, because each of them gets its verdict.
pub(super) fn category_network(reaches: &[&Examples], categories: &[String]) -> (Network, Usual) {
    let regions = || reaches.iter().flat_map(|reach| &reach.regions);
    let rows: Vec<Row<REGION_FEATURE_COUNT>> = regions()
        .map(|region| Row {
            features: region.features,
            class: class(categories, &region.category),
            weight: region.touched as f64,
        })
        .collect();
    let of = |category: &String| {
        let own = regions().filter(|region| region.category == *category);
        own.map(|region| region.description).collect()
    };
    let usual = Usual::fit(&categories.iter().map(of).collect::<Vec<_>>());
    (Network::fit(&rows, categories.len()), usual)
}
