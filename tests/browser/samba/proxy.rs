//! A bad connection between client and server: slow, stalled at a point, or cut there.

use std::{
    io::{Read, Write},
    net::{Shutdown, TcpListener, TcpStream},
    time::Duration,
};

/// How the connection treats the bytes that the client sends.
#[derive(Debug, Clone, Copy)]
pub struct NetworkLine {
    /// Bytes per second.
    pub rate: usize,
    /// After this number of bytes ...
    pub at: usize,
    /// ... nothing passes for this time; `None` = the connection is cut.
    pub stall: Option<Duration>,
}

/// Forwards one connection to `server`; returns the port to connect to.
pub fn serve(line: NetworkLine, server: u16) -> u16 {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let port = listener.local_addr().unwrap().port();
    std::thread::spawn(move || {
        let Ok((client, _)) = listener.accept() else { return };
        let Ok(server) = TcpStream::connect(("127.0.0.1", server)) else { return };
        let (mut down_from, mut down_to) = (server.try_clone().unwrap(), client.try_clone().unwrap());
        std::thread::spawn(move || {
            let _ = std::io::copy(&mut down_from, &mut down_to);
            let _ = down_to.shutdown(Shutdown::Both);
        });
        let _ = forward(line, &client, &server);
        let _ = client.shutdown(Shutdown::Both);
        let _ = server.shutdown(Shutdown::Both);
    });
    port
}

fn forward(line: NetworkLine, mut client: &TcpStream, mut server: &TcpStream) -> std::io::Result<()> {
    let (mut buffer, mut sent, mut has_stalled) = (vec![0; 8 << 10], 0, false);
    loop {
        let count = client.read(&mut buffer)?;
        if count == 0 {
            return Ok(());
        }
        sent += count;
        if sent > line.at && !has_stalled {
            has_stalled = true;
            let Some(stall) = line.stall else { return Ok(()) };
            std::thread::sleep(stall);
        }
        server.write_all(&buffer[..count])?;
        std::thread::sleep(Duration::from_secs_f64(count as f64 / line.rate as f64));
    }
}
