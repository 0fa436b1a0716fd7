//! The two networks of a touch model, fitted to rows of reaches.

use super::example::{Examples, TaxelExample};
use super::network::Network;

pub(super) fn touched_network(reaches: &[&Examples]) -> Network {
    let rows: Vec<_> = reaches.iter().flat_map(|reach| &reach.taxels).map(TaxelExample::row).collect();
    Network::fit(&rows, 2)
}

/// A region counts as often as it has touched taxels, because each of them gets its verdict.
pub(super) fn category_network(reaches: &[&Examples], categories: &[String]) -> Network {
    let regions = reaches.iter().flat_map(|reach| &reach.regions);
    let rows: Vec<_> = regions.map(|region| region.row(categories)).collect();
    Network::fit(&rows, categories.len())
}
