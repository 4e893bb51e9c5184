//! Backup, restore, and the check of all stored rows and files.

use crate::app::{LEDGER, Store, own_folder};
use crate::config::Config;
use crate::store::{self, BlobFolder, Blobs, Collected, StoreError, StoredFile};
use std::collections::{BTreeMap, BTreeSet};
use std::fs::{self, File};
use std::io;
use std::path::Path;

/// Copies ledger and blobs into a folder that does not exist; the service may run meanwhile.
pub(super) fn backup(data: &Path, folder: &Path) -> Result<String, String> {
    let store = Store::read_only(data)?;
    let folder_error = |error: io::Error| format!("{}: {error}", folder.display());
    fs::create_dir(folder).map_err(folder_error)?;
    let copy = folder.join(LEDGER);
    let from_store = |error: StoreError| error.to_string();
    // The ledger first: every file that it names exists already.
    store.ledger.copy_to(&copy).map_err(from_store)?;
    let copied = Store::read_only(folder)?;
    let checked = copied.ledger.check().map_err(from_store)?;
    let mut damaged = checked.damaged;
    let mut lost = Vec::new();
    let (mut files, mut bytes) = (0_u64, 0_u64);
    let to = BlobFolder::open(&folder.join("blobs")).map_err(from_store)?;
    for file in distinct(checked.files) {
        match copy_blob(&*store.blobs, &to, &file) {
            Ok(()) => {
                files += 1;
                bytes += file.bytes;
            }
            Err(StoreError::Damaged { what }) => lost.push((what, file.sha256)),
            Err(error) => return Err(error.to_string()),
        }
    }
    // A file that is missing here counts only if a row still names it: its recording may have been deleted since.
    let named = store.ledger.named_files().map_err(from_store)?.files;
    let named: BTreeSet<String> = named.into_iter().map(|file| file.sha256).collect();
    let lost = lost
        .into_iter()
        .filter(|(_, sha256)| named.contains(sha256));
    damaged.extend(lost.map(|(what, _)| what));
    File::open(&copy)
        .and_then(|file| file.sync_all())
        .map_err(folder_error)?;
    File::open(folder)
        .and_then(|file| file.sync_all())
        .map_err(folder_error)?;
    if damaged.is_empty() {
        return Ok(format!(
            "{files} files of {bytes} bytes and the ledger are in {}",
            folder.display()
        ));
    }
    Err(format!(
        "the copy lacks what is damaged: {}",
        damaged.join("; ")
    ))
}

/// Takes a backup as the data.
pub(super) fn restore(folder: &Path, data: &Path) -> Result<String, String> {
    if !folder.join(LEDGER).is_file() {
        return Err(format!("{}: no backup is here", folder.display()));
    }
    if data.join(LEDGER).exists() {
        let shown = data.display();
        return Err(format!(
            "{shown}: there are data already; name another folder with --data, or move these away"
        ));
    }
    let check = fsck(folder)?;
    if !check.is_sound {
        return Err(format!(
            "the backup is damaged, nothing was taken from it:\n{}",
            check.text
        ));
    }
    own_folder(data)?;
    let store = Store::read_only(folder)?;
    let from_store = |error: StoreError| error.to_string();
    let files = store.ledger.check().map_err(from_store)?.files;
    let to = BlobFolder::open(&data.join("blobs")).map_err(from_store)?;
    for file in distinct(files) {
        copy_blob(&*store.blobs, &to, &file).map_err(from_store)?;
    }
    // The ledger last: an interrupted restore leaves no data that a service would take.
    let unfinished = data.join("ledger.unfinished");
    let _ = fs::remove_file(&unfinished);
    store.ledger.copy_to(&unfinished).map_err(from_store)?;
    File::open(&unfinished)
        .and_then(|file| file.sync_all())
        .and_then(|()| fs::rename(&unfinished, data.join(LEDGER)))
        .and_then(|()| File::open(data)?.sync_all())
        .map_err(|error| format!("{}: {error}", data.display()))?;
    Ok(format!("{} holds what the backup held", data.display()))
}

/// Result of a check of the store.
pub(super) struct StoreCheck {
    /// True if nothing is damaged.
    pub(super) is_sound: bool,
    /// The result in words, with the damage.
    pub(super) text: String,
}

/// Reads every row and every file again.
pub(super) fn fsck(data: &Path) -> Result<StoreCheck, String> {
    let store = Store::read_only(data)?;
    let checked = store.ledger.check().map_err(|error| error.to_string())?;
    let mut damaged = checked.damaged;
    let files = distinct(checked.files);
    let mut bytes = 0;
    for file in &files {
        match store.blobs.open(&file.sha256) {
            Ok(_) => bytes += file.bytes,
            Err(StoreError::Damaged { what }) => damaged.push(format!("{what} ({})", file.name)),
            Err(error) => return Err(error.to_string()),
        }
    }
    let text = if damaged.is_empty() {
        format!(
            "{} files of {bytes} bytes and every row fit their hashes",
            files.len()
        )
    } else {
        format!("damaged:\n{}", damaged.join("\n"))
    };
    Ok(StoreCheck {
        is_sound: damaged.is_empty(),
        text,
    })
}

/// Removes the files that no row names and that are older than a day; no service may run meanwhile.
pub(super) fn collect(config: &Config) -> Result<String, String> {
    Store::is_there(&config.data)?;
    let store = Store::open(config)?;
    let collected = store::collect(&*store.ledger, &*store.blobs);
    let Collected { files, bytes, .. } = collected.map_err(|error| error.to_string())?;
    Ok(format!(
        "{files} files of {bytes} bytes that no row names were removed"
    ))
}

fn distinct(files: Vec<StoredFile>) -> Vec<StoredFile> {
    let by_hash = files.into_iter().map(|file| (file.sha256.clone(), file));
    by_hash.collect::<BTreeMap<_, _>>().into_values().collect()
}

fn copy_blob(from: &dyn Blobs, to: &BlobFolder, file: &StoredFile) -> Result<(), StoreError> {
    let mut bytes = from.open(&file.sha256)?;
    let mut writer = to.begin()?;
    let mut piece = vec![0; 64 << 10];
    loop {
        let count = io::Read::read(&mut bytes, &mut piece)?;
        if count == 0 {
            break;
        }
        writer.write(&piece[..count])?;
    }
    writer.finish(&file.name).map(|_| ())
}
