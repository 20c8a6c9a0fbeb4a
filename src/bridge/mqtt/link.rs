//! The way to the broker. After an outage it begins from nothing: what was queued before it is never sent after it.

use crate::bridge::limits::{
    BROKER_GOODBYE, BROKER_PATIENCE_S, BROKER_QUEUE, BROKER_RETRY_AFTER, KEEP_ALIVE_S, PACKET_BYTES,
    SEND_BYTES, TAKEOVER,
};
use crate::bridge::{BridgeError, lock};
use crate::files::{SETTINGS_BYTES, read_text};
use rumqttc::tokio_rustls::rustls::{self, CertificateError};
use rumqttc::{
    Client, ConnectReturnCode, ConnectionError, Event, LastWill, MqttOptions, Outgoing, Packet, QoS,
    TlsError, Transport,
};
use std::path::{Path, PathBuf};
use std::sync::mpsc::{Receiver, Sender, channel};
use std::sync::{Arc, Mutex};
use std::time::Instant;

/// Where the broker is, and how to get in.
#[derive(Debug, Clone)]
pub struct Broker {
    /// Name or address.
    pub host: String,
    /// TCP.
    pub port: u16,
    /// Certificates, PEM: who may vouch for the broker. `None`: no TLS.
    pub ca: Option<PathBuf>,
    /// `None`: anonymous.
    pub login: Option<Login>,
}

/// A user and where the password is.
#[derive(Debug, Clone)]
pub struct Login {
    /// The name.
    pub user: String,
    /// Its first line is the password.
    pub password_file: PathBuf,
}

/// One publication.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Publication {
    pub topic: String,
    pub payload: String,
    /// Whether the broker keeps it for those who come later, and confirms it.
    pub is_retained: bool,
    /// Whose reading it is.
    pub channel: Option<String>,
}

impl Publication {
    pub fn retained(topic: String, payload: &str) -> Publication {
        Publication { is_retained: true, ..Publication::passing(topic, payload) }
    }

    pub fn passing(topic: String, payload: &str) -> Publication {
        Publication { topic, payload: payload.to_owned(), is_retained: false, channel: None }
    }

    fn qos(&self) -> QoS {
        if self.is_retained { QoS::AtLeastOnce } else { QoS::AtMostOnce }
    }
}

/// Whether there is a broker.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum BrokerState {
    /// Yes; `is_new`: it, or who listens to it, must be told everything anew.
    Up {
        is_new: bool,
    },
    Down,
}

/// Shared with the thread that talks to the broker.
#[derive(Default)]
struct LinkState {
    client: Option<Client>,
    is_new: bool,
    is_over: bool,
}

/// The link.
pub struct Link {
    shared: Arc<Mutex<LinkState>>,
    ended: Receiver<()>,
}

impl Link {
    /// Starts to connect. `will`: what the broker says when we end without a word; `births`: a topic on which somebody
    /// says "online" who must then be told everything.
    pub fn start(
        broker: Broker,
        id: &str,
        will: Publication,
        births: Option<String>,
    ) -> Result<Link, BridgeError> {
        let options = options(&broker, id, &will)?;
        let shared = Arc::new(Mutex::new(LinkState::default()));
        let (end, ended) = channel();
        let talker = Talker { broker, births, shared: Arc::clone(&shared), said: None, end };
        let thread = std::thread::Builder::new().name("mqtt".to_owned());
        thread
            .spawn(move || talker.talk(&options))
            .map_err(|error| BridgeError::System { what: "a thread for the broker", error })?;
        Ok(Link { shared, ended })
    }

    pub fn state(&mut self) -> BrokerState {
        let mut shared = lock(&self.shared);
        match shared.client {
            Some(_) => BrokerState::Up { is_new: std::mem::take(&mut shared.is_new) },
            None => BrokerState::Down,
        }
    }

    /// Whether it was taken: not if the broker is slow or gone.
    pub fn publish(&self, message: Publication) -> bool {
        let client = lock(&self.shared).client.clone();
        client.is_some_and(|client| {
            let (qos, Publication { topic, payload, is_retained, .. }) = (message.qos(), message);
            client.try_publish(topic, qos, is_retained, payload).is_ok()
        })
    }

    /// Everything is told anew as soon as there is room for it.
    pub fn introduce_again(&self) {
        lock(&self.shared).is_new = true;
    }

    /// Many at once; if there is no room for all, [`Link::introduce_again`].
    pub fn publish_all(&self, messages: Vec<Publication>) {
        for message in messages {
            if !self.publish(message) {
                return self.introduce_again();
            }
        }
    }

    /// A last word, and the end.
    pub fn end(self, last: Publication) {
        lock(&self.shared).is_over = true;
        let client = lock(&self.shared).client.clone();
        if self.publish(last) && client.is_some_and(|client| client.try_disconnect().is_ok()) {
            // Without an answer, the broker speaks our will.
            let _ = self.ended.recv_timeout(BROKER_GOODBYE);
        }
    }
}

/// The thread of the link.
struct Talker {
    broker: Broker,
    births: Option<String>,
    shared: Arc<Mutex<LinkState>>,
    /// What the log knows of an outage.
    said: Option<String>,
    end: Sender<()>,
}

impl Talker {
    fn talk(mut self, options: &MqttOptions) {
        while !lock(&self.shared).is_over {
            let since = Instant::now();
            let error = self.connection(options);
            lock(&self.shared).client = None;
            if let Some(error) = error {
                self.complain(&error, since);
                std::thread::sleep(BROKER_RETRY_AFTER);
            }
        }
        let _ = self.end.send(());
    }

    /// One connection, from nothing to its end; the queue goes with it.
    fn connection(&mut self, options: &MqttOptions) -> Option<ConnectionError> {
        let (client, mut connection) = Client::new(options.clone(), BROKER_QUEUE);
        let network = &mut connection.eventloop.network_options;
        network.set_connection_timeout(BROKER_PATIENCE_S);
        network.set_tcp_nodelay(true);
        // Little waits in the kernel of what a slow broker has not taken.
        network.set_tcp_send_buffer_size(SEND_BYTES);
        loop {
            match connection.recv() {
                Ok(Ok(Event::Incoming(Packet::ConnAck(_)))) => self.greet(&client),
                Ok(Ok(Event::Incoming(Packet::Publish(publish)))) => {
                    lock(&self.shared).is_new |= publish.payload[..] == *b"online";
                }
                Ok(Ok(Event::Outgoing(Outgoing::Disconnect))) | Err(_) => return None,
                Ok(Ok(_)) => {}
                Ok(Err(error)) => return Some(error),
            }
        }
    }

    fn greet(&mut self, client: &Client) {
        log::info!("connected to the broker {}:{}", self.broker.host, self.broker.port);
        self.said = None;
        if let Some(births) = &self.births {
            // Its queue is empty: it takes this.
            let _ = client.try_subscribe(births.clone(), QoS::AtMostOnce);
        }
        let mut shared = lock(&self.shared);
        (shared.client, shared.is_new) = (Some(client.clone()), true);
    }

    /// Once for each thing that is wrong.
    fn complain(&mut self, error: &ConnectionError, since: Instant) {
        let text = error.to_string();
        if self.said.as_ref() != Some(&text) {
            let Broker { host, port, .. } = &self.broker;
            let hint = hint(error, since.elapsed() < TAKEOVER);
            log::warn!("broker {host}:{port}: {text}{hint}; trying again every {BROKER_RETRY_AFTER:?}");
            self.said = Some(text);
        }
    }
}

fn hint(error: &ConnectionError, was_short: bool) -> &'static str {
    use ConnectReturnCode::{BadClientId, BadUserNamePassword, NotAuthorized};
    match error {
        ConnectionError::ConnectionRefused(BadUserNamePassword | NotAuthorized) => {
            ": look at --user and --password-file"
        }
        ConnectionError::ConnectionRefused(BadClientId) => ": the broker does not like --id",
        ConnectionError::Tls(error) => of_tls(error),
        ConnectionError::MqttState(_) if was_short => {
            ": does it want TLS, or is there another client of the same --id?"
        }
        _ => "",
    }
}

/// What rustls has against the certificate of the broker, if that is it.
fn of_tls(error: &TlsError) -> &'static str {
    let inner = if let TlsError::Io(error) = error { error.get_ref() } else { None };
    match inner.and_then(|error| error.downcast_ref()) {
        Some(rustls::Error::InvalidCertificate(error)) => match error {
            CertificateError::UnknownIssuer => ": the file of --ca does not vouch for this broker",
            CertificateError::NotValidForName | CertificateError::NotValidForNameContext { .. } => {
                ": its certificate is for another name; write that into --broker"
            }
            CertificateError::Expired
            | CertificateError::ExpiredContext { .. }
            | CertificateError::NotValidYet
            | CertificateError::NotValidYetContext { .. } => {
                ": its certificate is not valid at the time of this machine's clock; is that set? (timedatectl)"
            }
            _ => "",
        },
        _ => ": is this its port for TLS?",
    }
}

fn options(broker: &Broker, id: &str, will: &Publication) -> Result<MqttOptions, BridgeError> {
    let mut options = MqttOptions::new(format!("cermd-{id}"), (broker.host.as_str(), broker.port));
    options.set_keep_alive(KEEP_ALIVE_S).set_clean_session(true);
    options.set_max_packet_size(PACKET_BYTES, PACKET_BYTES);
    options.set_last_will(LastWill::new(&will.topic, will.payload.clone(), will.qos(), will.is_retained));
    if let Some(ca) = &broker.ca {
        options.set_transport(Transport::tls(read(ca)?.into_bytes(), None, None));
    }
    if let Some(Login { user, password_file }) = &broker.login {
        let password = read(password_file)?.lines().next().unwrap_or_default().to_owned();
        options.set_credentials(user, password);
        if broker.ca.is_none() && !matches!(broker.host.as_str(), "localhost" | "127.0.0.1" | "::1") {
            log::warn!("user and password go to {} for everybody to read: use --tls", broker.host);
        }
    }
    Ok(options)
}

fn read(path: &Path) -> Result<String, BridgeError> {
    read_text(path, SETTINGS_BYTES).map_err(|error| BridgeError::File { path: path.to_owned(), error })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io;

    fn hint_of(error: rustls::Error) -> &'static str {
        hint(&ConnectionError::Tls(TlsError::Io(io::Error::new(io::ErrorKind::InvalidData, error))), false)
    }

    #[test]
    fn what_is_wrong_with_a_certificate_is_told_apart() {
        for (error, wanted) in [
            (CertificateError::UnknownIssuer, "does not vouch"),
            (CertificateError::NotValidForName, "another name"),
            (CertificateError::Expired, "timedatectl"),
            (CertificateError::NotValidYet, "timedatectl"),
        ] {
            let hint = hint_of(rustls::Error::InvalidCertificate(error.clone()));
            assert!(hint.contains(wanted), "{error}: {hint}");
        }
        assert_eq!(hint_of(rustls::Error::InvalidCertificate(CertificateError::BadEncoding)), "");
        assert!(hint_of(rustls::Error::DecryptError).contains("port for TLS"));
    }
}
