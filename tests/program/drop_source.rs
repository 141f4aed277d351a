//! The source of a drag and drop under X11 (XDND, version 5), as a file manager is one: offers a file, answers what it is asked,
//! drops it. <https://www.freedesktop.org/wiki/Specifications/XDND/>

use std::error::Error;
use std::path::Path;
use std::time::{Duration, Instant};

use x11rb::connection::Connection;
use x11rb::protocol::Event;
use x11rb::protocol::xproto::{
    AtomEnum, ClientMessageEvent, ConnectionExt, CreateWindowAux, EventMask, PropMode, SELECTION_NOTIFY_EVENT,
    SelectionNotifyEvent, WindowClass,
};
use x11rb::wrapper::ConnectionExt as _;
use x11rb::{COPY_DEPTH_FROM_PARENT, COPY_FROM_PARENT, CURRENT_TIME};

/// How long the window may take to ask and to finish.
const PATIENCE: Duration = Duration::from_secs(60);

/// Drops a file on a window of this display; returns when the window says that it has it.
pub fn drop_file(display: &str, target: u32, path: &Path) -> Result<(), Box<dyn Error>> {
    let (x, screen) = x11rb::connect(Some(display))?;
    let root = x.setup().roots[screen].root;
    let source = x.generate_id()?;
    let aux = CreateWindowAux::new();
    x.create_window(
        COPY_DEPTH_FROM_PARENT,
        source,
        root,
        0,
        0,
        1,
        1,
        0,
        WindowClass::INPUT_OUTPUT,
        COPY_FROM_PARENT,
        &aux,
    )?;
    let atom = |name: &str| -> Result<u32, Box<dyn Error>> { Ok(x.intern_atom(false, name.as_bytes())?.reply()?.atom) };
    let (selection, uris, copy) = (atom("XdndSelection")?, atom("text/uri-list")?, atom("XdndActionCopy")?);
    let finished = atom("XdndFinished")?;
    x.set_selection_owner(source, selection, CURRENT_TIME)?;
    let say = |name: &str, data: [u32; 5]| -> Result<(), Box<dyn Error>> {
        let message = ClientMessageEvent::new(32, target, atom(name)?, data);
        x.send_event(false, target, EventMask::NO_EVENT, message)?;
        x.flush()?;
        Ok(())
    };
    say("XdndEnter", [source, 5 << 24, uris, 0, 0])?;
    say("XdndPosition", [source, 0, (640 << 16) | 400, CURRENT_TIME, copy])?;
    let begin = Instant::now();
    while begin.elapsed() < PATIENCE {
        match x.poll_for_event()? {
            Some(Event::SelectionRequest(asked)) => {
                let list = format!("file://{}\r\n", path.display());
                x.change_property8(PropMode::REPLACE, asked.requestor, asked.property, uris, list.as_bytes())?;
                let answer = SelectionNotifyEvent {
                    response_type: SELECTION_NOTIFY_EVENT,
                    sequence: 0,
                    time: asked.time,
                    requestor: asked.requestor,
                    selection,
                    target: uris,
                    property: asked.property,
                };
                x.send_event(false, asked.requestor, EventMask::NO_EVENT, answer)?;
                say("XdndDrop", [source, 0, CURRENT_TIME, 0, 0])?;
            }
            Some(Event::ClientMessage(message)) if message.type_ == finished => {
                x.destroy_window(source)?;
                x.flush()?;
                return Ok(());
            }
            Some(_) => {}
            None => std::thread::sleep(Duration::from_millis(2)),
        }
    }
    let none: u32 = AtomEnum::NONE.into();
    say("XdndLeave", [source, none, 0, 0, 0])?;
    Err("the window did not take what was dropped on it".into())
}
