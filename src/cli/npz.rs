//! NumPy's .npz form: a zip of .npy arrays.

use std::io::{Seek, Write};

use anyhow::Result;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

/// Writes arrays one after the other.
pub struct NpzWriter<W: Write + Seek> {
    zip: ZipWriter<W>,
}

impl<W: Write + Seek> NpzWriter<W> {
    /// Begins a file.
    pub fn new(out: W) -> Self {
        Self { zip: ZipWriter::new(out) }
    }

    /// Adds an array of f32 in C order.
    pub fn floats(&mut self, name: &str, shape: &[usize], values: impl Iterator<Item = f32>) -> Result<()> {
        let shape: String = shape.iter().map(|n| format!("{n}, ")).collect();
        self.array(name, "<f4", &shape, &values.flat_map(f32::to_le_bytes).collect::<Vec<u8>>())
    }

    /// Adds a single string.
    pub fn text(&mut self, name: &str, text: &str) -> Result<()> {
        let utf32: Vec<u8> = text.chars().flat_map(|c| u32::from(c).to_le_bytes()).collect();
        self.array(name, &format!("<U{}", text.chars().count()), "", &utf32)
    }

    /// Ends the file.
    pub fn finish(self) -> Result<()> {
        self.zip.finish()?.flush()?;
        Ok(())
    }

    /// NumPy's format version 1.0: magic, length, and a dictionary padded so that the data is aligned to 64 bytes.
    fn array(&mut self, name: &str, descr: &str, shape: &str, data: &[u8]) -> Result<()> {
        let mut header = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({shape}), }}");
        let padding = 63 - (10 + header.len()) % 64;
        header.extend(std::iter::repeat_n(' ', padding));
        header.push('\n');
        let stored =
            SimpleFileOptions::default().compression_method(CompressionMethod::Stored).large_file(data.len() > 1 << 31);
        self.zip.start_file(format!("{name}.npy"), stored)?;
        self.zip.write_all(b"\x93NUMPY\x01\x00")?;
        self.zip.write_all(&u16::try_from(header.len())?.to_le_bytes())?;
        self.zip.write_all(header.as_bytes())?;
        self.zip.write_all(data)?;
        Ok(())
    }
}
