//! Limits on input: what a reader refuses to take in, so that memory stays bounded.

/// Limits on input; crossing one is an error that names it.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Limits {
    /// Bytes of a text recording, which is held in memory.
    pub text_bytes: u64,
    /// Bytes of a card or design file.
    pub settings_bytes: u64,
    /// Samples kept per channel.
    pub samples: u64,
    /// Columns of a table.
    pub columns: u64,
    /// Cells of a table kept as numbers when every channel is read.
    pub table_cells: u64,
    /// Bytes of one line of text.
    pub line_bytes: u64,
    /// Bytes of an archive (.zip, .tar.gz), which is held in memory.
    pub archive_bytes: u64,
    /// Entries of an archive, or files of a folder.
    pub archive_entries: u64,
    /// Bytes of an archive's files after decompression, those held at a time.
    pub unpacked_bytes: u64,
    /// Bytes of an archive's stream after decompression, those passed over included.
    pub unpacked_stream_bytes: u64,
    /// Ratio of bytes after decompression to bytes before it, past the first 4 MiB.
    pub unpacked_ratio: u64,
    /// Bytes of one MCAP record, a chunk included.
    pub mcap_record_bytes: u64,
    /// Bytes of one MCAP chunk after decompression.
    pub mcap_chunk_bytes: u64,
    /// Topics of an MCAP file.
    pub mcap_channels: u64,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            text_bytes: 256 << 20,
            settings_bytes: 1 << 20,
            samples: 8_000_000,
            columns: 4096,
            table_cells: 48_000_000,
            line_bytes: 1 << 20,
            archive_bytes: 64 << 20,
            archive_entries: 20_000,
            unpacked_bytes: 64 << 20,
            unpacked_stream_bytes: 1 << 30,
            unpacked_ratio: 200,
            mcap_record_bytes: 64 << 20,
            mcap_chunk_bytes: 64 << 20,
            mcap_channels: 4096,
        }
    }
}
