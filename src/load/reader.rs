//! The server's side of a WebSocket as a stream: chunks in, messages out. Of a frame only its header is kept, unless
//! the whole is wanted; the rest goes through the checksum where it lies. Knows no socket.

use crc32fast::Hasher;
use thiserror::Error;

use crate::wire::{HEADER_BYTES, MAGIC};

/// Where a header says its checksum, and how many of its bytes that covers.
const CRC_AT: usize = 80;
/// Largest text taken, bytes.
const MOST_TEXT: u64 = 1 << 20;
/// Largest frame taken, bytes.
const MOST_FRAME: u64 = 16 << 20;

/// The header of a frame as it came, read at the offsets of PROTOCOL.md section 5. Checked are magic, lengths and
/// checksum alone.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Head(pub [u8; HEADER_BYTES]);

impl Head {
    fn of<const N: usize>(&self, at: usize) -> [u8; N] {
        std::array::from_fn(|byte| self.0[at + byte])
    }

    /// Cascade, level, class and group.
    pub fn unit(&self) -> [u8; 4] {
        self.of(6)
    }

    /// Where the tile is in the patch, counted in tiles along x and z.
    pub fn tile(&self) -> [u16; 2] {
        [u16::from_le_bytes(self.of(16)), u16::from_le_bytes(self.of(18))]
    }

    /// The tick.
    pub fn tick(&self) -> u64 {
        u64::from_le_bytes(self.of(24))
    }

    /// The timeline.
    pub fn epoch(&self) -> u64 {
        u64::from_le_bytes(self.of(32))
    }

    fn header_bytes(&self) -> u16 {
        u16::from_le_bytes(self.of(4))
    }

    fn payload_bytes(&self) -> u32 {
        u32::from_le_bytes(self.of(52))
    }

    fn crc(&self) -> u32 {
        u32::from_le_bytes(self.of(CRC_AT))
    }

    /// Writes the header of another tick, with its checksum, over the first bytes of `frame`.
    pub fn seal(mut self, tick: u64, frame: &mut [u8]) {
        let payload = &frame[HEADER_BYTES..];
        self.0[24..32].copy_from_slice(&tick.to_le_bytes());
        self.0[52..56].copy_from_slice(&(payload.len() as u32).to_le_bytes());
        let mut crc = Hasher::new();
        crc.update(&self.0[..CRC_AT]);
        crc.update(payload);
        self.0[CRC_AT..CRC_AT + 4].copy_from_slice(&crc.finalize().to_le_bytes());
        frame[..HEADER_BYTES].copy_from_slice(&self.0);
    }
}

/// What is wrong with a binary message.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
pub enum BadFrame {
    /// Its header is not one.
    #[error("a frame has no proper header")]
    Header,
    /// Its length is not what its header says.
    #[error("a frame is not as long as its header says")]
    Length,
    /// Its bytes were changed.
    #[error("a frame's checksum is wrong")]
    Checksum,
}

/// The bytes are no WebSocket of a server; nothing after them can be read.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error("the server breaks the WebSocket protocol: {0}")]
pub struct BadStream(&'static str);

/// What came.
#[derive(Debug, PartialEq, Eq)]
pub enum Message<'a> {
    /// A text.
    Text(&'a str),
    /// A frame that is whole, its length, and its bytes if they are kept.
    Frame(Head, usize, &'a [u8]),
    /// A binary message that is no frame.
    Bad(BadFrame),
    /// A ping, to be answered with the same bytes.
    Ping(&'a [u8]),
    /// A close and its code, 1005 without one.
    Close(u16),
}

/// Reads a stream in chunks of any size.
#[derive(Debug, Default)]
pub struct StreamReader {
    /// Keep frames whole.
    keep: bool,
    /// The head of the WebSocket frame that is being read.
    ws: [u8; 10],
    ws_got: usize,
    /// Bytes of its payload to come; `None`: the head is being read.
    left: Option<u64>,
    control: Vec<u8>,
    message: Option<Begun>,
}

/// A message whose end has not come.
#[derive(Debug)]
enum Begun {
    Text(Vec<u8>),
    Binary { got: u64, head: [u8; HEADER_BYTES], crc: Hasher, whole: Vec<u8> },
}

impl StreamReader {
    /// A reader at the beginning of a stream, which keeps frames whole or not.
    pub fn new(keep: bool) -> Self {
        Self { keep, ..Self::default() }
    }

    /// Reads on.
    ///
    /// # Errors
    /// [`BadStream`] when the bytes can't be from a server.
    pub fn feed(&mut self, mut bytes: &[u8], mut on: impl FnMut(Message<'_>)) -> Result<(), BadStream> {
        while !bytes.is_empty() {
            let Some(left) = self.left else {
                bytes = self.read_head(bytes)?;
                // What is empty ends with its head.
                if self.left == Some(0) {
                    self.end(&mut on)?;
                }
                continue;
            };
            let n = left.min(bytes.len() as u64);
            let (part, rest) = bytes.split_at(n as usize);
            self.take(part)?;
            bytes = rest;
            self.left = Some(left - n);
            if left == n {
                self.end(&mut on)?;
            }
        }
        Ok(())
    }

    fn op(&self) -> u8 {
        self.ws[0] & 15
    }

    /// Takes bytes of a head; when it is complete, begins what it announces.
    fn read_head<'b>(&mut self, bytes: &'b [u8]) -> Result<&'b [u8], BadStream> {
        let wanted = match self.ws {
            _ if self.ws_got < 2 => 2,
            [_, 126, ..] => 4,
            [_, 127, ..] => 10,
            _ => 2,
        };
        let n = (wanted - self.ws_got).min(bytes.len());
        self.ws[self.ws_got..self.ws_got + n].copy_from_slice(&bytes[..n]);
        self.ws_got += n;
        let complete = self.ws_got == wanted && (wanted > 2 || self.ws[1] < 126);
        if !complete {
            if self.ws_got >= 2 && self.ws[1] & 128 != 0 {
                return Err(BadStream("it masks"));
            }
            return Ok(&bytes[n..]);
        }
        let length = match self.ws[1] {
            126 => u64::from(u16::from_be_bytes([self.ws[2], self.ws[3]])),
            127 => u64::from_be_bytes(std::array::from_fn(|byte| self.ws[2 + byte])),
            short => u64::from(short),
        };
        if self.ws[0] & 0x70 != 0 {
            return Err(BadStream("an extension that was not agreed"));
        }
        match (self.op(), &mut self.message) {
            (8..=10, _) if length < 126 && self.ws[0] & 128 != 0 => self.control.clear(),
            (0, Some(_)) => {}
            (1, empty @ None) => *empty = Some(Begun::Text(Vec::new())),
            (2, empty @ None) => {
                let head = [0; HEADER_BYTES];
                *empty = Some(Begun::Binary { got: 0, head, crc: Hasher::new(), whole: Vec::new() });
            }
            _ => return Err(BadStream("a frame that can't come here")),
        }
        self.left = Some(length);
        Ok(&bytes[n..])
    }

    fn take(&mut self, part: &[u8]) -> Result<(), BadStream> {
        if self.op() >= 8 {
            self.control.extend_from_slice(part);
            return Ok(());
        }
        match &mut self.message {
            Some(Begun::Text(text)) => {
                text.extend_from_slice(part);
                if text.len() as u64 > MOST_TEXT {
                    return Err(BadStream("a text without end"));
                }
            }
            Some(Begun::Binary { got, head, crc, whole }) => {
                let begun = (*got).min(HEADER_BYTES as u64) as usize;
                let (of_head, payload) = part.split_at(part.len().min(HEADER_BYTES - begun));
                head[begun..begun + of_head.len()].copy_from_slice(of_head);
                if begun < CRC_AT && begun + of_head.len() >= CRC_AT {
                    crc.update(&head[..CRC_AT]);
                }
                crc.update(payload);
                *got += part.len() as u64;
                if *got > MOST_FRAME {
                    return Err(BadStream("a message without end"));
                }
                if self.keep {
                    whole.extend_from_slice(part);
                }
            }
            None => {}
        }
        Ok(())
    }

    /// The payload is complete.
    fn end(&mut self, on: &mut impl FnMut(Message<'_>)) -> Result<(), BadStream> {
        (self.left, self.ws_got) = (None, 0);
        match self.op() {
            8 => on(Message::Close(match self.control[..] {
                [high, low, ..] => u16::from_be_bytes([high, low]),
                _ => 1005,
            })),
            9 => on(Message::Ping(&self.control)),
            10 => {}
            // More of this message will come.
            _ if self.ws[0] & 128 == 0 => {}
            _ => match self.message.take() {
                Some(Begun::Text(text)) => match std::str::from_utf8(&text) {
                    Ok(text) => on(Message::Text(text)),
                    Err(_) => return Err(BadStream("a text that is not UTF-8")),
                },
                Some(Begun::Binary { got, head, crc, whole }) => on(match judge(got, Head(head), crc) {
                    Ok(head) => Message::Frame(head, got as usize, &whole),
                    Err(bad) => Message::Bad(bad),
                }),
                None => {}
            },
        }
        Ok(())
    }
}

fn judge(got: u64, head: Head, crc: Hasher) -> Result<Head, BadFrame> {
    if got < HEADER_BYTES as u64 || head.0[..4] != MAGIC || usize::from(head.header_bytes()) != HEADER_BYTES {
        return Err(BadFrame::Header);
    }
    if got != HEADER_BYTES as u64 + u64::from(head.payload_bytes()) {
        return Err(BadFrame::Length);
    }
    if crc.finalize() != head.crc() {
        return Err(BadFrame::Checksum);
    }
    Ok(head)
}

/// A client's text as bytes of a WebSocket. Masked by zeros: masks keep pages in browsers from fooling proxies, and
/// this is neither.
pub fn client_text(text: &str) -> Vec<u8> {
    client_frame(1, text.as_bytes())
}

/// A client's WebSocket frame of any operation code: 1 text, 8 close, 10 pong.
pub fn client_frame(op: u8, payload: &[u8]) -> Vec<u8> {
    let mut bytes = vec![128 | op];
    match payload.len() {
        n @ 0..126 => bytes.push(128 | n as u8),
        n if n <= 0xffff => {
            bytes.push(128 | 126);
            bytes.extend_from_slice(&(n as u16).to_be_bytes());
        }
        n => {
            bytes.push(128 | 127);
            bytes.extend_from_slice(&(n as u64).to_be_bytes());
        }
    }
    bytes.extend_from_slice(&[0; 4]);
    bytes.extend_from_slice(payload);
    bytes
}
