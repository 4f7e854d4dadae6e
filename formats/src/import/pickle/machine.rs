//! The machine that a pickle is a program for: a stack, a list of objects, and a memo.

use std::collections::HashMap;
use std::vec::Vec;

use super::literals::literal;
use super::opcodes as op;
use super::source::Source;
use super::value::{Object, Value};
use crate::import::ImportError;
use crate::import::budget::Budget;

#[derive(Debug)]
pub(super) struct Machine<'a, 'b> {
    pub(super) source: Source<'a>,
    stack: Vec<Value<'a>>,
    /// Heights of the stack: what lies below the last one is out of reach.
    marks: Vec<usize>,
    memo: HashMap<usize, Value<'a>>,
    pub(super) objects: Vec<Object<'a>>,
    pub(super) budget: &'b mut Budget,
}

impl<'a, 'b> Machine<'a, 'b> {
    pub(super) fn new(source: Source<'a>, budget: &'b mut Budget) -> Self {
        let (stack, marks, objects) = (Vec::new(), Vec::new(), Vec::new());
        Self { source, stack, marks, memo: HashMap::new(), objects, budget }
    }

    /// Runs up to the end and gives the value that is left.
    pub(super) fn run(&mut self) -> Result<Value<'a>, ImportError> {
        loop {
            match self.source.byte()? {
                op::STOP => return self.pop(),
                opcode => self.step(opcode)?,
            }
        }
    }

    fn step(&mut self, opcode: u8) -> Result<(), ImportError> {
        match opcode {
            op::PROTO => self.protocol(),
            op::FRAME => self.source.array::<8>().map(|_| ()),
            op::MARK => self.mark(),
            op::POP => self.drop_top(),
            op::POP_MARK => self.pop_to_mark().map(|_| ()),
            op::DUP => self.top().and_then(|top| self.push(top)),
            op::PUT | op::BINPUT | op::LONG_BINPUT | op::MEMOIZE => self.remember(opcode),
            op::GET | op::BINGET | op::LONG_BINGET => self.recall(opcode),
            op::EMPTY_LIST | op::EMPTY_SET | op::EMPTY_TUPLE => {
                self.push_object(Object::Sequence(Vec::new()))
            }
            op::EMPTY_DICT => self.push_object(Object::Dict(Vec::new())),
            op::LIST | op::TUPLE | op::FROZENSET => {
                let items = self.pop_to_mark()?;
                self.push_object(Object::Sequence(items))
            }
            op::TUPLE1 => self.tuple(1),
            op::TUPLE2 => self.tuple(2),
            op::TUPLE3 => self.tuple(3),
            op::DICT => {
                let items = self.pop_to_mark()?;
                self.push_object(Object::Dict(Vec::new()))?;
                self.set_items(&items)
            }
            op::APPEND => {
                let item = self.pop()?;
                self.append(&[item])
            }
            op::APPENDS | op::ADDITEMS => {
                let items = self.pop_to_mark()?;
                self.append(&items)
            }
            op::SETITEM => {
                let value = self.pop()?;
                let key = self.pop()?;
                self.set_items(&[key, value])
            }
            op::SETITEMS => {
                let items = self.pop_to_mark()?;
                self.set_items(&items)
            }
            op::GLOBAL => {
                let (module, name) = (self.source.line()?, self.source.line()?);
                self.push_object(Object::Global { module, name })
            }
            op::STACK_GLOBAL => match (self.pop()?, self.pop()?) {
                (Value::Text(name), Value::Text(module)) => {
                    self.push_object(Object::Global { module, name })
                }
                _ => Err(self.expected("the names of a module and of what it holds")),
            },
            op::REDUCE | op::NEWOBJ => {
                let arguments = self.pop()?;
                let callee = self.pop()?;
                let made = self.call(callee, arguments)?;
                self.push(made)
            }
            op::BUILD => {
                let state = self.pop()?;
                let target = self.top()?;
                self.build(target, state)
            }
            op::BINPERSID => {
                let id = self.pop()?;
                let storage = self.storage(id)?;
                self.push_object(Object::Storage(storage))
            }
            // Calls in ways that no checkpoint makes them: refused, if possible by name.
            op::INST => {
                let (module, name) = (self.source.line()?, self.source.line()?);
                Err(ImportError::Call(super::shown_name(module, name)))
            }
            op::OBJ => {
                let callee = self.pop_to_mark()?.first().copied();
                Err(self.refuse_call(callee.unwrap_or(Value::None)))
            }
            op::NEWOBJ_EX => {
                let (_, _, callee) = (self.pop()?, self.pop()?, self.pop()?);
                Err(self.refuse_call(callee))
            }
            _ => match literal(opcode, &mut self.source)? {
                Some(value) => self.push(value),
                None => Err(ImportError::Opcode { found: opcode, at: self.source.at() - 1 }),
            },
        }
    }

    fn protocol(&mut self) -> Result<(), ImportError> {
        match self.source.byte()? {
            0..=5 => Ok(()),
            _ => Err(self.expected("a protocol of at most 5")),
        }
    }

    fn push(&mut self, value: Value<'a>) -> Result<(), ImportError> {
        self.budget.spend_on::<Value<'_>>(1)?;
        self.stack.push(value);
        Ok(())
    }

    fn push_object(&mut self, object: Object<'a>) -> Result<(), ImportError> {
        let value = self.make(object)?;
        self.push(value)
    }

    /// Adds to the list of objects.
    pub(super) fn make(&mut self, object: Object<'a>) -> Result<Value<'a>, ImportError> {
        self.budget.spend_on::<Object<'_>>(1)?;
        self.objects.push(object);
        Ok(Value::Object(self.objects.len() - 1))
    }

    /// The object that a value stands for.
    pub(super) fn object(&self, value: Value<'a>) -> Option<&Object<'a>> {
        match value {
            Value::Object(index) => self.objects.get(index),
            _ => None,
        }
    }

    /// The values from the last mark on.
    fn reach(&self) -> usize {
        self.stack.len() - self.marks.last().copied().unwrap_or(0)
    }

    fn top(&self) -> Result<Value<'a>, ImportError> {
        let top = self.stack.last().filter(|_| self.reach() > 0);
        top.copied().ok_or_else(|| self.expected("a value on the stack"))
    }

    fn pop(&mut self) -> Result<Value<'a>, ImportError> {
        let top = self.top()?;
        self.stack.pop();
        Ok(top)
    }

    /// A mark counts as a value here.
    fn drop_top(&mut self) -> Result<(), ImportError> {
        if self.reach() == 0 && self.marks.pop().is_some() {
            return Ok(());
        }
        self.pop().map(|_| ())
    }

    fn mark(&mut self) -> Result<(), ImportError> {
        self.budget.spend_on::<usize>(1)?;
        self.marks.push(self.stack.len());
        Ok(())
    }

    fn pop_to_mark(&mut self) -> Result<Vec<Value<'a>>, ImportError> {
        let mark = self.marks.pop().ok_or_else(|| self.expected("a mark on the stack"))?;
        self.budget.spend_on::<Value<'_>>(self.stack.len() - mark)?;
        Ok(self.stack.drain(mark..).collect())
    }

    fn tuple(&mut self, n: usize) -> Result<(), ImportError> {
        if self.reach() < n {
            return Err(self.expected("more values on the stack"));
        }
        self.budget.spend_on::<Value<'_>>(n)?;
        let items = self.stack.drain(self.stack.len() - n..).collect();
        self.push_object(Object::Sequence(items))
    }

    fn append(&mut self, items: &[Value<'a>]) -> Result<(), ImportError> {
        self.budget.spend_on::<Value<'_>>(items.len())?;
        if let Value::Object(index) = self.top()?
            && let Object::Sequence(sequence) = &mut self.objects[index]
        {
            sequence.extend_from_slice(items);
            return Ok(());
        }
        Err(self.expected("a list to append to"))
    }

    fn set_items(&mut self, items: &[Value<'a>]) -> Result<(), ImportError> {
        self.budget.spend_on::<Value<'_>>(items.len())?;
        let (pairs, rest) = items.as_chunks::<2>();
        if let Value::Object(index) = self.top()?
            && let Object::Dict(dict) = &mut self.objects[index]
            && rest.is_empty()
        {
            dict.extend(pairs.iter().map(|[key, value]| (*key, *value)));
            return Ok(());
        }
        Err(self.expected("a dictionary, and pairs for it"))
    }

    fn memo_index(&mut self, opcode: u8) -> Result<usize, ImportError> {
        Ok(match opcode {
            op::BINPUT | op::BINGET => self.source.byte()?.into(),
            op::LONG_BINPUT | op::LONG_BINGET => u32::from_le_bytes(self.source.array()?) as usize,
            op::MEMOIZE => self.memo.len(),
            _ => {
                let line = self.source.line()?;
                line.parse().map_err(|_| self.expected("the number of a place in the memo"))?
            }
        })
    }

    fn remember(&mut self, opcode: u8) -> Result<(), ImportError> {
        let index = self.memo_index(opcode)?;
        let top = self.top()?;
        self.budget.spend_on::<(usize, Value<'_>, u64)>(1)?;
        self.memo.insert(index, top);
        Ok(())
    }

    fn recall(&mut self, opcode: u8) -> Result<(), ImportError> {
        let index = self.memo_index(opcode)?;
        let value = self.memo.get(&index).copied();
        self.push(value.ok_or_else(|| self.expected("a place of the memo that is filled"))?)
    }

    pub(super) const fn expected(&self, expected: &'static str) -> ImportError {
        self.source.expected(expected)
    }

    /// The error for a call that is not understood.
    pub(super) fn refuse_call(&self, callee: Value<'a>) -> ImportError {
        match self.object(callee) {
            Some(Object::Global { module, name }) => {
                ImportError::Call(super::shown_name(module, name))
            }
            _ => self.expected("something to call"),
        }
    }
}
