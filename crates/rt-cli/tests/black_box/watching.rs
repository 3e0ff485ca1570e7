//! Renders that the image viewer tev shows as they grow: its protocol, received here.

use std::io::{BufReader, Read};
use std::net::{TcpListener, TcpStream};
use std::thread::{self, JoinHandle};
use std::time::Duration;

use rt_image::Image;

use crate::program::Workplace;

/// An image as the viewer paints it.
#[derive(Clone, Debug, Default, PartialEq)]
struct Painting {
    name: String,
    width: usize,
    height: usize,
    channels: Vec<String>,
    /// Pixel by pixel; NaN where nothing was painted.
    values: Vec<f32>,
    updates: usize,
}

impl Painting {
    fn assert_is(&self, film: &Image) {
        assert_eq!([self.width, self.height], [film.width() as usize, film.height() as usize]);
        let expected: Vec<f32> = match film.alpha() {
            None => film.pixels().as_flattened().to_vec(),
            Some(alpha) => film.pixels().iter().zip(alpha).flat_map(|(&[r, g, b], &a)| [r, g, b, a]).collect(),
        };
        assert_eq!(self.values, expected);
    }
}

/// A packet without its length, read from its beginning.
struct Packet<'a>(&'a [u8]);

impl Packet<'_> {
    fn bytes<const N: usize>(&mut self) -> [u8; N] {
        let (bytes, rest) = self.0.split_first_chunk().expect("a longer packet");
        self.0 = rest;
        *bytes
    }

    fn byte(&mut self) -> u8 {
        u8::from_le_bytes(self.bytes())
    }

    fn int(&mut self) -> usize {
        u32::from_le_bytes(self.bytes()) as usize
    }

    fn long(&mut self) -> usize {
        usize::try_from(u64::from_le_bytes(self.bytes())).expect("a small number")
    }

    fn float(&mut self) -> f32 {
        f32::from_le_bytes(self.bytes())
    }

    fn text(&mut self) -> String {
        let end = self.0.iter().position(|&byte| byte == 0).expect("the end of a text");
        let text = String::from_utf8(self.0[..end].to_vec()).expect("text");
        self.0 = &self.0[end + 1..];
        text
    }

    fn texts(&mut self) -> Vec<String> {
        (0..self.int()).map(|_| self.text()).collect()
    }
}

/// Does what a packet says.
fn obey(packet: &mut Packet<'_>, painting: &mut Painting) {
    const CREATE: u8 = 4;
    const UPDATE: u8 = 6;
    let kind = packet.byte();
    let _grab_focus = packet.byte();
    let name = packet.text();
    if kind == CREATE {
        let (width, height, channels) = (packet.int(), packet.int(), packet.texts());
        let values = vec![f32::NAN; width * height * channels.len()];
        *painting = Painting { name, width, height, channels, values, updates: 0 };
    } else {
        assert_eq!((kind, &name), (UPDATE, &painting.name));
        let channels = packet.texts();
        let [left, top, width, height] = core::array::from_fn(|_| packet.int());
        let offsets: Vec<_> = channels.iter().map(|_| packet.long()).collect();
        let strides: Vec<_> = channels.iter().map(|_| packet.long()).collect();
        let count = packet.0.len() / 4;
        let data: Vec<f32> = (0..count).map(|_| packet.float()).collect();
        for (channel, name) in channels.iter().enumerate() {
            let place = painting.channels.iter().position(|known| known == name).expect("a channel of the image");
            for pixel in 0..width * height {
                let (x, y) = (left + pixel % width, top + pixel / width);
                let value = data[offsets[channel] + pixel * strides[channel]];
                painting.values[(y * painting.width + x) * painting.channels.len() + place] = value;
            }
        }
        painting.updates += 1;
    }
    assert!(packet.0.is_empty(), "{} bytes are left of a packet", packet.0.len());
}

/// The next packet, or `None` at the end.
fn next_packet(stream: &mut impl Read) -> Option<Vec<u8>> {
    let mut length = [0; 4];
    stream.read_exact(&mut length).ok()?;
    let mut packet = vec![0; u32::from_le_bytes(length) as usize - length.len()];
    stream.read_exact(&mut packet).expect("a whole packet");
    Some(packet)
}

/// A viewer at a port of its own, and what comes of what it does with the one connection that it takes.
fn viewer<T: Send + 'static>(watch: impl FnOnce(TcpStream) -> T + Send + 'static) -> (String, JoinHandle<T>) {
    let listener = TcpListener::bind("127.0.0.1:0").expect("a port");
    let address = listener.local_addr().expect("an address").to_string();
    (address, thread::spawn(move || watch(listener.accept().expect("a connection").0)))
}

/// Paints all that comes. All states, from the image that was created to the last.
fn paint(stream: TcpStream) -> Vec<Painting> {
    let mut stream = BufReader::new(stream);
    let mut states = vec![Painting::default()];
    while let Some(packet) = next_packet(&mut stream) {
        let mut next = states.last().expect("one").clone();
        obey(&mut Packet(&packet), &mut next);
        states.push(next);
    }
    states
}

#[test]
fn the_viewer_shows_the_pixels_of_the_file() {
    let place = Workplace::with_scene();
    for (options, image, channels, tiles) in [
        ("", "a.pfm", "RGB", 6),
        ("--integrator path --passes 3", "b.exr", "RGB", 6),
        ("--spp 4 --time 1h", "c.pfm", "RGB", 18),
        ("--background transparent --crop 5,6,30,21", "d.exr", "RGBA", 4),
    ] {
        let (address, watching) = viewer(paint);
        let run = place.succeed(&format!("render scene.ron {options} -o {image} --display-server {address}"));
        assert!(run.stderr.is_empty(), "{run:?}");
        let states = watching.join().expect("no panic");
        let (created, last) = (&states[1], states.last().expect("one"));
        assert_eq!((created.name.as_str(), created.channels.concat().as_str()), ("scene", channels), "{options}");
        assert!(created.values.iter().all(|value| value.is_nan()), "{options}");
        // Each tile when it is done, and everything once more at the end.
        assert_eq!(last.updates, tiles + 1, "{options}");
        let film = place.film(image);
        last.assert_is(&film);
        states[states.len() - 2].assert_is(&film);
    }
}

#[test]
fn a_viewer_that_leaves_costs_a_warning_and_nothing_else() {
    let place = Workplace::with_scene();
    // More than a thousand tiles.
    let render = "render scene.ron --size 640x480 --spp 1";
    place.succeed(&format!("{render} -o alone.pfm"));
    let (address, watching) = viewer(|mut stream| next_packet(&mut stream).is_some());
    let run = place.succeed(&format!("{render} -o watched.pfm --display-server {address}"));
    assert!(watching.join().expect("no panic"));
    let lines: Vec<_> = run.stderr.lines().collect();
    assert!(
        matches!(lines.as_slice(), [line] if line.starts_with("warning: lost the display server at 127.0.0.1:")),
        "{run:?}"
    );
    assert!(run.stderr.contains("the render continues"), "{run:?}");
    assert_eq!(place.read("watched.pfm"), place.read("alone.pfm"));
}

#[test]
fn a_viewer_that_hangs_delays_no_render() {
    let place = Workplace::with_scene();
    let (stop, stopped) = std::sync::mpsc::channel::<()>();
    let (address, watching) = viewer(move |stream| {
        // Nothing is read, and nothing closed, as long as the render runs.
        let _ = stopped.recv_timeout(Duration::from_secs(120));
        drop(stream);
    });
    // More than the system takes on its way.
    let options = "--integrator normals --spp 1 --sampler centre --size 1800x1800 -o hung.pfm";
    let run = place.succeed(&format!("render scene.ron {options} --display-server {address}"));
    drop(stop);
    watching.join().expect("no panic");
    assert_eq!(run.stderr.matches("warning: ").count(), 1, "{run:?}");
    assert_eq!(place.film("hung.pfm").width(), 1800);
}

#[test]
fn without_a_viewer_nothing_is_rendered() {
    let place = Workplace::with_scene();
    let closed = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("an address");
    for address in [closed.to_string().as_str(), "nowhere", "127.0.0.1:port", ":", "127.0.0.1:99999"] {
        let run = place.run(&format!("render scene.ron --display-server {address}"));
        assert_eq!(run.code, Some(2), "{run:?}");
        assert!(run.stderr.starts_with(&format!("error: --display-server {address}: ")), "{run:?}");
        let is_address = address == closed.to_string();
        let advice = if is_address { "start `tev` first" } else { "expected HOST:PORT" };
        assert!(run.stderr.contains(advice) && run.stderr.lines().count() == 1, "{run:?}");
    }
    assert_eq!(place.files(), ["scene.ron"]);
}
