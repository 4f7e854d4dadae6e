//! Serves a folder to a browser, as any static file server does.

use std::io::{BufRead, BufReader, Write};
use std::net::{TcpListener, TcpStream};
use std::path::{Path, PathBuf};
use std::time::Duration;

/// The address of a server of this folder, which runs as long as the tests do.
pub(crate) fn serve(folder: &Path) -> String {
    let listener = TcpListener::bind("127.0.0.1:0").unwrap();
    let address = format!("http://{}", listener.local_addr().unwrap());
    let folder = folder.to_owned();
    std::thread::spawn(move || {
        for stream in listener.incoming().flatten() {
            let folder = folder.clone();
            // A browser that goes away is no failure.
            std::thread::spawn(move || _ = answer(&folder, &stream));
        }
    });
    address
}

fn answer(folder: &Path, mut stream: &TcpStream) -> std::io::Result<()> {
    stream.set_read_timeout(Some(Duration::from_secs(60)))?;
    let mut reader = BufReader::new(stream);
    let mut request = String::new();
    reader.read_line(&mut request)?;
    let mut header = String::new();
    while reader.read_line(&mut header)? > 2 {
        header.clear();
    }
    let path = request.split(' ').nth(1).unwrap_or("/");
    let found = file(folder, path.split('?').next().unwrap_or("/"));
    let (status, kind, body) =
        match found.and_then(|path| Some((kind(&path), std::fs::read(&path).ok()?))) {
            Some((kind, body)) => ("200 OK", kind, body),
            // What browsers ask of every server.
            None if path == "/favicon.ico" => ("204 No Content", "image/x-icon", Vec::new()),
            None => ("404 Not Found", "text/plain", b"not here".to_vec()),
        };
    write!(
        stream,
        "HTTP/1.1 {status}\r\nContent-Type: {kind}\r\nContent-Length: {}\r\nConnection: close\r\n\r\n",
        body.len()
    )?;
    stream.write_all(&body)
}

/// A file of the folder itself; nothing below or above it.
fn file(folder: &Path, path: &str) -> Option<PathBuf> {
    let name = path.strip_prefix('/').filter(|name| !name.contains(['/', '\\']))?;
    Some(folder.join(if name.is_empty() { "index.html" } else { name }))
}

fn kind(path: &Path) -> &'static str {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("html") => "text/html; charset=utf-8",
        Some("js") => "text/javascript; charset=utf-8",
        Some("css") => "text/css; charset=utf-8",
        Some("json") => "application/json",
        Some("wasm") => "application/wasm",
        _ => "application/octet-stream",
    }
}
