//! Names of a test's files: header, list and channels.

/// True if a name is that of a test's header or channel list.
pub(crate) fn is_test_file(name: &str) -> bool {
    has_suffix(name, "mme") || has_suffix(name, "chn")
}

/// True if a file's name has a suffix, in capitals or small letters.
pub(crate) fn has_suffix(name: &str, suffix: &str) -> bool {
    suffix_of(name).is_some_and(|extension| extension.eq_ignore_ascii_case(suffix))
}

/// Returns the part of a file's name after its last point.
pub(super) fn suffix_of(name: &str) -> Option<&str> {
    let file = name.rsplit('/').next()?;
    let (stem, suffix) = file.rsplit_once('.')?;
    (!stem.is_empty()).then_some(suffix)
}

/// True if a name is that of a channel file.
pub(crate) fn is_channel_file(name: &str) -> bool {
    number_of(name).is_some()
}

/// Returns the number that a channel file has as its suffix, of three digits or more.
pub(crate) fn number_of(name: &str) -> Option<u32> {
    let digits = |suffix: &&str| suffix.len() >= 3 && suffix.bytes().all(|b| b.is_ascii_digit());
    suffix_of(name).filter(digits)?.parse().ok()
}

/// Returns the key that the files of one test share: their folder, without the `Channel` in it, and their
/// stem in small letters.
pub(super) fn test_of(name: &str) -> (String, String) {
    let (folder, file) = name.rsplit_once('/').unwrap_or(("", name));
    let (above, last) = folder.rsplit_once('/').unwrap_or(("", folder));
    let is_inner = last.eq_ignore_ascii_case("channel");
    let folder = if is_inner { above } else { folder };
    let stem = file.rsplit_once('.').map_or(file, |(stem, _)| stem);
    (folder.to_string(), stem.to_lowercase())
}

/// Keeps the names of the test's header, list and channels, without shadows.
pub(super) fn kept(mut names: Vec<String>) -> Vec<String> {
    names.retain(|name| (is_test_file(name) || is_channel_file(name)) && !is_shadow(name));
    names.sort();
    names
}

/// True if a file is one of the shadows that macOS packs beside each file.
pub(crate) fn is_shadow(name: &str) -> bool {
    let file = name.rsplit('/').next().unwrap_or(name);
    file.starts_with("._") || name.starts_with("__MACOSX/")
}
