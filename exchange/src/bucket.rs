//! Data sets in S3-like storage.
//!
//! A set is stored below one address, such as `s3://bucket/my-set`, with one object for each file of its folder. No
//! object is ever replaced: each is put only if it does not exist yet. The list of checksums is put first and so
//! decides which set has the place. `meta/info.json` is put last, so an address without it holds no complete set yet.
//! Several machines may push the same set at the same time, and each may be interrupted at any point.

use std::path::{Path, PathBuf};
use std::time::Duration;

use object_store::aws::{AmazonS3, AmazonS3Builder};
use object_store::path::Path as Key;
use object_store::{Error, ObjectStore, ObjectStoreExt, PutMode, PutPayload};
use tokio::runtime::{Builder, Runtime};
use underbrush_recording::InputError;
use underbrush_recording::disk::{Dataset, DatasetCopy};

use crate::ExchangeError;

/// How often a put is tried if the connection fails. The library repeats other requests itself. Conditional puts are
/// repeated here, because only this code knows that an object that already exists may come from the failed attempt.
/// Choice: the waits double, so all attempts together take about a minute.
const ATTEMPTS: u32 = 8;
/// The first wait. Choice, see [`ATTEMPTS`].
const FIRST_WAIT: Duration = Duration::from_millis(500);

/// A place for one data set in storage.
#[derive(Debug)]
pub struct Place {
    store: AmazonS3,
    prefix: Key,
    /// The address as given, without a slash at the end.
    address: String,
    runtime: Runtime,
}

/// How many files a copy had, and how many of them were transferred now.
#[derive(Clone, Copy, Debug, Default)]
pub struct Transfer {
    /// Files of the set.
    pub files: usize,
    /// Files that were not there before.
    pub transferred: usize,
    /// Bytes of the transferred files.
    pub bytes: u64,
}

impl Place {
    /// The place with an address such as `s3://bucket/my-set`. Credentials, region and endpoint come from the
    /// environment (`AWS_ACCESS_KEY_ID`, `AWS_REGION`, `AWS_ENDPOINT_URL`, …). Nothing is requested yet.
    ///
    /// # Errors
    /// [`ExchangeError::Input`] for another kind of address, [`ExchangeError::Bucket`] for invalid environment
    /// variables.
    pub fn new(address: &str) -> Result<Self, ExchangeError> {
        let address = address.trim_end_matches('/').to_owned();
        let bad = || {
            let allowed = "s3://BUCKET/NAME with a name for the data set";
            InputError::new(
                &address,
                "address",
                &address,
                allowed,
                "name a bucket and a data set in it",
            )
        };
        let (bucket, name) = address
            .strip_prefix("s3://")
            .and_then(|rest| rest.split_once('/'))
            .ok_or_else(bad)?;
        let prefix = Key::parse(name)
            .ok()
            .filter(|_| !bucket.is_empty() && !name.is_empty())
            .ok_or_else(bad)?;
        let invalid = |source| ExchangeError::Bucket {
            address: address.clone(),
            action: "be used",
            source: Box::new(source),
        };
        let store = AmazonS3Builder::from_env()
            .with_bucket_name(bucket)
            .build()
            .map_err(invalid)?;
        let runtime = Builder::new_current_thread().enable_all().build();
        let runtime = runtime.map_err(|source| {
            invalid(Error::Generic {
                store: "S3",
                source: Box::new(source),
            })
        })?;
        Ok(Place {
            store,
            prefix,
            address,
            runtime,
        })
    }

    /// Copies a data set to this place. Files that are already there are skipped. `sent` is called after each file.
    /// Only one file is in memory at a time, some 100 MB.
    ///
    /// # Errors
    /// [`ExchangeError::Input`] if another set is there; [`ExchangeError::Disk`] if the set is damaged;
    /// [`ExchangeError::Bucket`] if storage fails. A push that failed can be repeated.
    pub fn push(&self, dataset: &Dataset, mut sent: impl FnMut()) -> Result<Transfer, ExchangeError> {
        let files = dataset.files();
        let mut transfer = Transfer {
            files: files.len(),
            ..Transfer::default()
        };
        for name in files {
            // The list is always put, because that decides which set has the place.
            if name == DatasetCopy::LIST || !self.has(&name, dataset.dir())? {
                let bytes = dataset.file_bytes(&name)?;
                if self.put_new(&name, &bytes)? {
                    transfer.transferred += 1;
                    transfer.bytes += bytes.len() as u64;
                } else if name == DatasetCopy::LIST && self.get(&name)? != bytes {
                    let (found, allowed) = ("the files of another data set", "an empty place, or the same data set");
                    let remedy = "choose another address";
                    return Err(InputError::new(&self.address, "data set", found, allowed, remedy).into());
                }
            }
            sent();
        }
        Ok(transfer)
    }

    /// Copies the data set at this place into an empty or new folder, or completes a copy that was interrupted. All
    /// hashes are checked. `received` is called after each file, with the number of files that are to be transferred.
    ///
    /// # Errors
    /// [`ExchangeError::Input`] if there is no finished set or one with damaged files; [`ExchangeError::Disk`] if the
    /// folder holds anything else or cannot be written; [`ExchangeError::Bucket`] if storage fails.
    pub fn pull(&self, out: &Path, mut received: impl FnMut(usize)) -> Result<(Dataset, Transfer), ExchangeError> {
        let Some(list) = self.get_if_there(DatasetCopy::LIST)? else {
            let remedy = "check the address, or push a data set there";
            let found = format!("no {}", DatasetCopy::LIST);
            return Err(InputError::new(&self.address, "data set", found, "a data set", remedy).into());
        };
        let copy = DatasetCopy::begin(out, &list)?;
        let missing = copy.missing()?;
        let mut transfer = Transfer {
            transferred: missing.len(),
            ..Transfer::default()
        };
        for name in &missing {
            let Some(bytes) = self.get_if_there(name)? else {
                let remedy = "wait until it has been pushed, or push it again";
                let found = format!("no {name}");
                return Err(InputError::new(&self.address, "data set", found, "a finished data set", remedy).into());
            };
            copy.add(name, &bytes, &PathBuf::from(self.address_of(name)))?;
            transfer.bytes += bytes.len() as u64;
            received(missing.len());
        }
        let dataset = copy.finish()?;
        transfer.files = dataset.files().len();
        Ok((dataset, transfer))
    }

    fn address_of(&self, name: &str) -> String {
        format!("{}/{name}", self.address)
    }

    fn key(&self, name: &str) -> Key {
        name.split('/').fold(self.prefix.clone(), |key, part| key.join(part))
    }

    fn failed(&self, name: &str, action: &'static str) -> impl FnOnce(Error) -> ExchangeError {
        let address = self.address_of(name);
        move |source| ExchangeError::Bucket {
            address,
            action,
            source: Box::new(source),
        }
    }

    /// Whether there is an object with the size of the file below `dir`. An object of another size was not written by
    /// this program and is an error.
    fn has(&self, name: &str, dir: &Path) -> Result<bool, ExchangeError> {
        let there = match self.runtime.block_on(self.store.head(&self.key(name))) {
            Err(Error::NotFound { .. }) => return Ok(false),
            there => there.map_err(self.failed(name, "look for it"))?.size,
        };
        let size = std::fs::metadata(dir.join(name)).map_or(0, |file| file.len());
        if there != size {
            let [found, allowed] = [there, size].map(|bytes| format!("{bytes} bytes"));
            let remedy = "remove the object and push again";
            return Err(InputError::new(self.address_of(name), "object", found, allowed, remedy).into());
        }
        Ok(true)
    }

    /// Puts an object unless there is one, and returns whether it did. After a lost connection, the object may exist
    /// because of this very call, which then returns `false`.
    fn put_new(&self, name: &str, bytes: &[u8]) -> Result<bool, ExchangeError> {
        let key = self.key(name);
        let payload = PutPayload::from(bytes.to_vec());
        let mut wait = FIRST_WAIT;
        for attempt in 1.. {
            let put = self.store.put_opts(&key, payload.clone(), PutMode::Create.into());
            match self.runtime.block_on(put) {
                Ok(_) => return Ok(true),
                Err(Error::AlreadyExists { .. }) => return Ok(false),
                Err(Error::Generic { .. }) if attempt < ATTEMPTS => std::thread::sleep(wait),
                Err(error) => return Err(self.failed(name, "write it")(error)),
            }
            wait *= 2;
        }
        Ok(false)
    }

    fn get_if_there(&self, name: &str) -> Result<Option<Vec<u8>>, ExchangeError> {
        let key = self.key(name);
        let got = self
            .runtime
            .block_on(async { self.store.get(&key).await?.bytes().await });
        match got {
            Err(Error::NotFound { .. }) => Ok(None),
            got => got
                .map(|bytes| Some(bytes.to_vec()))
                .map_err(self.failed(name, "read it")),
        }
    }

    fn get(&self, name: &str) -> Result<Vec<u8>, ExchangeError> {
        let missing = || {
            InputError::new(
                self.address_of(name),
                "object",
                "none",
                "an object",
                "push the data set again",
            )
        };
        Ok(self.get_if_there(name)?.ok_or_else(missing)?)
    }
}
