//! The wire against its vectors, and against ten thousand of everything it should refuse.

use serde_json::Value;
use std::fs;
use swellcast::wire::{ClientMessage, FrameHeader, HEADER_BYTES, ServerMessage, split};

use crate::random::Random;
use crate::vectors::{bad_messages, describe, folder, from_clients, from_later_servers, from_server, samples};

const DRAWS: usize = 10_000;

#[test]
fn a_valid_frame_reads_as_its_description_and_writes_the_same_bytes() {
    for sample in samples() {
        let bytes = fs::read(folder().join(sample.name).with_extension("bin")).unwrap();
        let (header, payload) = split(&bytes).unwrap_or_else(|e| panic!("{}: {e}", sample.name));
        let text = fs::read_to_string(folder().join(sample.name).with_extension("json")).unwrap();
        assert_eq!(text, describe(&sample));
        let json: Value = serde_json::from_str(&text).unwrap();
        let decimal = |field: &str| json["header"][field].as_str().unwrap().parse::<u64>().unwrap();
        assert_eq!(
            (header.tick, header.epoch, header.sequence),
            (decimal("tick"), decimal("epoch"), decimal("sequence"))
        );
        assert_eq!(header.crc, json["header"]["crc"]);
        assert_eq!(json["planes"].as_array().unwrap().len(), usize::from(header.channels));
        let counts: Vec<i16> = payload.as_chunks().0.iter().map(|b| i16::from_le_bytes(*b)).collect();
        assert_eq!(counts, sample.planes.concat(), "{}", sample.name);

        let mut again = vec![0; HEADER_BYTES];
        again.extend(payload);
        header.seal(&mut again);
        assert_eq!(again, bytes, "{}", sample.name);
    }
}

#[test]
fn random_bytes_are_refused() {
    let mut random = Random(1);
    let good = samples()[0].bytes();
    for _ in 0..DRAWS {
        // Half begin like a frame, so that the draw reaches past the first fields.
        let mut bytes: Vec<u8> = (0..random.below(600)).map(|_| random.bits() as u8).collect();
        let kept = if random.below(2) == 0 { 0 } else { random.below(HEADER_BYTES).min(bytes.len()) };
        bytes[..kept].copy_from_slice(&good[..kept]);
        assert!(split(&bytes).is_err());
    }
}

#[test]
fn a_flipped_bit_is_never_accepted() {
    let good = samples()[0].bytes();
    assert!(split(&good).is_ok());
    // 472 bytes: all 3776 single flips; then pairs of flips, which a CRC-32 catches at this length, too.
    for bit in 0..good.len() * 8 {
        let mut bytes = good.clone();
        bytes[bit / 8] ^= 1 << (bit % 8);
        assert!(split(&bytes).is_err(), "bit {bit}");
    }
    let mut random = Random(2);
    for _ in 0..DRAWS {
        let mut bytes = good.clone();
        let (a, b) = (random.below(good.len() * 8), random.below(good.len() * 8));
        bytes[a / 8] ^= 1 << (a % 8);
        bytes[b / 8] ^= 1 << (b % 8);
        assert!(a == b || split(&bytes).is_err(), "bits {a} and {b}");
    }
}

#[test]
fn sealed_random_headers_are_read_back_or_refused() {
    let mut random = Random(3);
    let (good, template) = (samples()[0].bytes(), samples()[0].header);
    for _ in 0..DRAWS {
        let value = random.bits() >> random.below(64);
        let header = match random.below(9) {
            0 => FrameHeader { n: value as u16, level_n: value as u16, ..template },
            1 => FrameHeader { level_n: value as u16, ..template },
            2 => FrameHeader { group: value as u8, ..template },
            3 => FrameHeader { flags: value as u8, ..template },
            4 => FrameHeader { tick: value, ..template },
            5 => FrameHeader { payload_bytes: value as u32, ..template },
            6 => FrameHeader { step: [f32::from_bits(value as u32); 3], ..template },
            7 => FrameHeader { tile_x: value as u16, channels: (value >> 16) as u16, ..template },
            _ => FrameHeader { epoch: value, sequence: random.bits(), layout: value as u32, cascade: 9, ..template },
        };
        let mut bytes = good.clone();
        header.seal(&mut bytes);
        if let Ok((read, payload)) = split(&bytes) {
            assert_eq!((FrameHeader { crc: 0, ..read }, payload), (header, &good[HEADER_BYTES..]));
        }
    }
}

#[test]
fn valid_messages_read_as_what_they_are() {
    for (about, message, text) in from_clients() {
        assert_eq!(ClientMessage::parse(&text), Ok(message), "{about}");
    }
    for (about, message) in from_server() {
        assert_eq!(ServerMessage::parse(&message.to_json()).unwrap(), Some(message), "{about}");
    }
    for (about, text, ignore) in from_later_servers() {
        assert_eq!(ServerMessage::parse(text).unwrap().is_none(), ignore, "{about}");
    }
}

#[test]
fn a_number_that_its_type_turns_infinite_is_refused() {
    let (_, hello) = from_server().into_iter().find(|(about, _)| *about == "hello").unwrap();
    let text = hello.to_json();
    for field in ["displacement_m", "slope", "foam", "velocity_mps"] {
        let (before, after) = text.split_once(&format!("\"{field}\":")).unwrap();
        let (_, after) = after.split_once([',', '}']).unwrap();
        let end = if field == "velocity_mps" { '}' } else { ',' };
        let with = |number: &str| ServerMessage::parse(&format!("{before}\"{field}\":{number}{end}{after}"));
        assert!(with("0.25").is_ok() && with("3.4e38").is_ok(), "{field}");
        assert!(with("3.5e38").is_err() && with("-1e39").is_err(), "{field}");
    }
}

#[test]
fn a_bad_message_is_refused_with_its_code_and_field() {
    for bad in bad_messages() {
        let Err(error) = ClientMessage::parse(&bad.text) else { panic!("accepted, though {}: {}", bad.why, bad.text) };
        let code = serde_json::to_value(error.code).unwrap();
        assert_eq!((code.as_str().unwrap(), error.field.as_deref()), (bad.code, bad.field), "{}: {error}", bad.why);
        assert!(error.detail.len() < 400, "a refusal doesn't echo the whole message: {}", error.detail.len());
    }
}

#[test]
fn a_refusal_echoes_only_the_beginning_of_a_text() {
    let long = "\u{7f}".repeat(4000);
    let unit = |class: &str| format!(r#"{{"cascade":0,"level":0,"class":"{class}","group":"foam"}}"#);
    for text in [
        format!(r#"{{"type":"{long}"}}"#),
        format!(r#"{{"type":"time","{long}":1}}"#),
        format!(r#"{{"type":"subscribe","id":1,"rate_hz":15,"units":[{}]}}"#, unit(&long[..3900])),
    ] {
        let error = ClientMessage::parse(&text).unwrap_err();
        assert!(error.detail.len() < 1000, "{} bytes", error.detail.len());
    }
}

#[test]
fn a_time_is_echoed_to_the_last_bit() {
    let mut random = Random(4);
    for _ in 0..DRAWS {
        let t0 = f64::from_bits(random.bits());
        if t0.is_finite() {
            let text = serde_json::to_string(&ClientMessage::Time(swellcast::wire::Time { t0 })).unwrap();
            let Ok(ClientMessage::Time(read)) = ClientMessage::parse(&text) else { panic!("{text}") };
            assert_eq!(read.t0.to_bits(), t0.to_bits(), "{text}");
        }
    }
}

#[test]
fn mutated_and_random_messages_give_a_clean_result() {
    let mut random = Random(5);
    let mut seeds: Vec<String> = from_clients().into_iter().map(|(_, _, text)| text).collect();
    seeds.extend(from_server().into_iter().map(|(_, message)| message.to_json()));
    let alphabet: Vec<char> = "{}[]\":,\\ntruefalse0123456789eE+-. \u{0}é\u{1F30A}".chars().collect();
    for _ in 0..DRAWS {
        let mut text: Vec<char> = match random.below(4) {
            0 => (0..random.below(80)).map(|_| alphabet[random.below(alphabet.len())]).collect(),
            _ => seeds[random.below(seeds.len())].chars().collect(),
        };
        for _ in 0..=random.below(4) {
            let at = random.below(text.len() + 1);
            match random.below(4) {
                0 => text.insert(at, alphabet[random.below(alphabet.len())]),
                1 if at < text.len() => drop(text.remove(at)),
                2 if at < text.len() => text[at] = alphabet[random.below(alphabet.len())],
                _ => text.truncate(at.max(1)),
            }
        }
        let text: String = text.into_iter().collect();
        let _ = ServerMessage::parse(&text);
        if let Ok(message) = ClientMessage::parse(&text) {
            let again = serde_json::to_string(&message).unwrap();
            assert_eq!(ClientMessage::parse(&again), Ok(message), "{text}");
        }
    }
}
