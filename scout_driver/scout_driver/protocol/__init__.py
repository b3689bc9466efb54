"""The Scout's serial protocol, without any input or output: frames, commands and replies to and from bytes.

Source: the behaviour of the vendor's client library (Ndirect 2.6.13 and 2.7) and of third-party drivers.
"""
