//! Who TLS says the server is: a certificate from files, or one of its own that nobody vouches for.

use std::fmt;
use std::fs::{self, OpenOptions};
use std::io::{self, Write as _};
use std::path::{Path, PathBuf};
use std::sync::Arc;

use ring::digest::{SHA256, digest};
use thiserror::Error;
use tokio_rustls::TlsAcceptor;
use tokio_rustls::rustls::crypto::ring::default_provider;
use tokio_rustls::rustls::pki_types::pem::{self, PemObject};
use tokio_rustls::rustls::pki_types::{CertificateDer, PrivateKeyDer, PrivatePkcs8KeyDer};
use tokio_rustls::rustls::{self, ServerConfig};

/// What a folder keeps its own certificate and key in, DER.
const KEPT: [&str; 2] = ["certificate.der", "certificate-key.der"];

/// A certificate with its key, ready to take connections.
#[derive(Clone)]
pub struct Identity {
    acceptor: TlsAcceptor,
    certificate: CertificateDer<'static>,
}

/// Why there is none.
#[derive(Debug, Error)]
pub enum IdentityError {
    /// A file can't be read, or holds nothing of the kind.
    #[error("{path}: {source}")]
    File {
        /// The file.
        path: PathBuf,
        /// Why.
        source: pem::Error,
    },
    /// A file holds no certificate.
    #[error("{0} holds no certificate, must hold one or a chain in PEM")]
    Empty(PathBuf),
    /// A certificate of the server's own can't be kept, or read again.
    #[error("{path}: {source}")]
    Kept {
        /// The file.
        path: PathBuf,
        /// Why.
        source: io::Error,
    },
    /// What is kept is no certificate with its key.
    #[error("{why}; remove {files} in {folder}, and another is made", files = KEPT.join(" and "))]
    Spoilt {
        /// Where.
        folder: PathBuf,
        /// What is wrong with it.
        why: String,
    },
    /// Certificate and key don't fit each other, or are of a kind that is not known.
    #[error("certificate and key: {0}")]
    Refused(#[from] rustls::Error),
    /// No certificate could be made.
    #[error("making a certificate: {0}")]
    Unmade(#[from] rcgen::Error),
}

impl Identity {
    /// A chain of certificates, the server's own first, and its key, both in PEM.
    ///
    /// # Errors
    /// [`IdentityError`].
    pub fn from_files(certificate: &Path, key: &Path) -> Result<Self, IdentityError> {
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| IdentityError::File { path, source }
        };
        let chain = CertificateDer::pem_file_iter(certificate).and_then(Iterator::collect::<Result<Vec<_>, _>>);
        let chain = chain.map_err(failed(certificate))?;
        if chain.is_empty() {
            return Err(IdentityError::Empty(certificate.to_owned()));
        }
        Self::new(chain, PrivateKeyDer::from_pem_file(key).map_err(failed(key))?)
    }

    /// A certificate for these names and addresses that says it by itself: whoever connects compares the fingerprint.
    ///
    /// # Errors
    /// [`IdentityError`] for a name that can't stand in a certificate.
    pub fn self_signed(names: Vec<String>) -> Result<Self, IdentityError> {
        let made = rcgen::generate_simple_self_signed(names)?;
        Self::of_der(made.cert.der().to_vec(), made.signing_key.serialize_der())
    }

    /// The same, kept in a folder: headsets that were told to go on know it again after a restart. Its names are those that
    /// it was made with; to have another one made, its files are removed.
    ///
    /// # Errors
    /// [`IdentityError`], also for a folder that can't be written to.
    pub fn kept(folder: &Path, names: Vec<String>) -> Result<Self, IdentityError> {
        let [certificate, key] = KEPT.map(|name| folder.join(name));
        let failed = |path: &Path| {
            let path = path.to_owned();
            move |source| IdentityError::Kept { path, source }
        };
        if !certificate.exists() {
            let made = rcgen::generate_simple_self_signed(names)?;
            // The key first, the certificate whole: where there is a certificate, there is all of it.
            write_secret(&key, &made.signing_key.serialize_der()).map_err(failed(&key))?;
            let beside = certificate.with_extension("new");
            fs::write(&beside, made.cert.der()).map_err(failed(&beside))?;
            fs::rename(&beside, &certificate).map_err(failed(&certificate))?;
        }
        let read = |path: &Path| fs::read(path).map_err(failed(path));
        let kept = Self::of_der(read(&certificate)?, read(&key)?);
        kept.map_err(|why| IdentityError::Spoilt { folder: folder.to_owned(), why: why.to_string() })
    }

    fn of_der(certificate: Vec<u8>, key: Vec<u8>) -> Result<Self, IdentityError> {
        Self::new(vec![certificate.into()], PrivatePkcs8KeyDer::from(key).into())
    }

    fn new(chain: Vec<CertificateDer<'static>>, key: PrivateKeyDer<'static>) -> Result<Self, IdentityError> {
        let certificate = chain[0].clone();
        let config = ServerConfig::builder_with_provider(Arc::new(default_provider()));
        let mut config =
            config.with_safe_default_protocol_versions()?.with_no_client_auth().with_single_cert(chain, key)?;
        config.alpn_protocols = vec![b"http/1.1".to_vec()];
        Ok(Self { acceptor: TlsAcceptor::from(Arc::new(config)), certificate })
    }

    /// The server's own certificate, DER.
    pub fn certificate(&self) -> &[u8] {
        &self.certificate
    }

    /// SHA-256 of the certificate as browsers show it: pairs of hexadecimal digits.
    pub fn fingerprint(&self) -> String {
        let hash = digest(&SHA256, &self.certificate);
        hash.as_ref().iter().map(|byte| format!("{byte:02X}")).collect::<Vec<_>>().join(":")
    }

    pub(super) fn acceptor(&self) -> TlsAcceptor {
        self.acceptor.clone()
    }
}

/// Writes what nobody else may read.
fn write_secret(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let mut options = OpenOptions::new();
    options.write(true).create(true).truncate(true);
    #[cfg(unix)]
    std::os::unix::fs::OpenOptionsExt::mode(&mut options, 0o600);
    options.open(path)?.write_all(bytes)
}

impl fmt::Debug for Identity {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Identity").field(&self.fingerprint()).finish()
    }
}
