//! A load balancer before several nodes of a farm.

use std::{
    io,
    net::{Shutdown, TcpListener, TcpStream},
    thread,
};

/// Leads each connection to the next of these nodes (`http://host:port`); its own address. It ends with the test program.
pub fn balance(nodes: &[String]) -> String {
    let places: Vec<String> = nodes.iter().map(|node| node.replace("http://", "")).collect();
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    thread::spawn(move || {
        for (client, place) in listener.incoming().zip(places.iter().cycle()) {
            let (Ok(client), Ok(node)) = (client, TcpStream::connect(place)) else { continue };
            pass_on(&client, &node);
            pass_on(&node, &client);
        }
    });
    address
}

fn pass_on(from: &TcpStream, to: &TcpStream) {
    let (mut from, mut to) = (from.try_clone().unwrap(), to.try_clone().unwrap());
    thread::spawn(move || {
        _ = io::copy(&mut from, &mut to);
        _ = to.shutdown(Shutdown::Write);
    });
}
