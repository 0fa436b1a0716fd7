//! Tables in Parquet files, through Parquet's own column interface.
//!
//! A table is described once, by the fields of its rows (`row.rs`). From this follow the columns in memory
//! (`column.rs`), what is written (`write.rs`) and read (`read.rs`), and the documents.

mod arrow_schema;
pub(super) mod batch;
pub(super) mod column;
pub(super) mod parquet_input;
pub(super) mod plain_pages;
pub(super) mod read;
pub(super) mod row;
pub(super) mod row_groups;
pub(super) mod write;

pub(super) use batch::Batch;
pub(super) use column::{Column, Rows, Text, Type, Value, Values};
pub(super) use parquet_input::broken;
pub(super) use read::{COLUMNS_KEY, ParquetTable, Want, unknown};
pub(super) use row::{Described, Field, Row, Width, row};
pub(super) use row_groups::{EpisodeRows, Footers};
pub(super) use write::{EPISODE_COLUMN, Encoder, Group, ParquetFile, ROWS_PER_BATCH, write_table};
